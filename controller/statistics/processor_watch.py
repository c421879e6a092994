"""The kernel's data on the processors: slowed down, or taken away by a hypervisor.

For the statistics process only, since it reads files.
"""

import os
from pathlib import Path

_SLOW = 0.7  # of the maximum clock: below it the processor counts as slowed down
_STEAL = 8  # column of /proc/stat (proc(5)); column 0 is the processor's name


class Throttling:
    """Detects a slowed-down processor by its thermal events or its present clock."""

    def __init__(self, root: Path = Path("/sys/devices/system/cpu")) -> None:
        """Processors without such files count as never slowed down."""
        self._counts = sorted(root.glob("cpu[0-9]*/thermal_throttle/core_throttle_count"))
        self._clocks = sorted(root.glob("cpu[0-9]*/cpufreq"))
        self._last = self._events()

    def _events(self) -> int:
        return sum(_number(path) for path in self._counts)

    def seen(self) -> bool:
        """Whether a processor was slowed down since the last call, or is now."""
        events = self._events()
        risen, self._last = events > self._last, events
        slow = any(
            0 < _number(clock / "scaling_cur_freq") < _SLOW * _number(clock / "cpuinfo_max_freq")
            for clock in self._clocks
        )
        return risen or slow


class Stolen:
    """Time that a hypervisor took the processors of a process away: "steal" of /proc/stat."""

    def __init__(self, process: int, stat: Path = Path("/proc/stat")) -> None:
        """Without data from the kernel the time is zero."""
        self._process, self._stat = process, stat
        self._tick_s = 1.0 / os.sysconf("SC_CLK_TCK")
        self._last = self._ticks()

    def _ticks(self) -> dict[str, int]:
        try:
            lines = self._stat.read_text().splitlines()
        except OSError:
            return {}
        rows = [line.split() for line in lines if line.startswith("cpu") and not line.startswith("cpu ")]
        return {row[0]: int(row[_STEAL]) for row in rows if len(row) > _STEAL}

    def passed_s(self) -> float:
        """The time since the last call, of the processor that lost most."""
        ticks, before = self._ticks(), self._last
        self._last = ticks
        try:
            allowed = {f"cpu{number}" for number in os.sched_getaffinity(self._process)}
        except (OSError, AttributeError):
            allowed = set(ticks)
        lost = (ticks[name] - before.get(name, ticks[name]) for name in ticks if name in allowed)
        return max(0, *lost, 0) * self._tick_s


def _number(path: Path) -> int:
    try:
        return int(path.read_text())
    except (OSError, ValueError):
        return 0
