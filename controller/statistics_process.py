"""The loop's statistics, once a second, from a process of its own: it reads the shared block and writes to the log.

Start it with start_statistics(). It ends with the loop, however that came to its end.
"""

import contextlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from common.stop_signal import StopSignal
from common.structured_log import log
from common.user_error import UserError
from controller.histogram import percentiles_us
from controller.loop_block import LoopBlock, Overrun
from controller.overrun import REMEDY, Cause, overrun_cause

RECORDER_ENDED = (
    "damping goes on; nothing more is recorded or sent as telemetry until the controller starts again; "
    "mend the recording with `stillarm recover`"
)
_PERIOD_S = 1.0
_POLL_S = 0.1
_SLOW = 0.7  # of the highest clock: slowed down
_PROCESS = "controller"


def start_statistics(block_name: str, recorder: int) -> subprocess.Popen[bytes]:
    """Start it for the block that this process has made; in a session of its own, where no Ctrl-C reaches it.

    recorder: the number of the recorder's process, whose end it tells.
    """
    root = str(Path(__file__).resolve().parents[1])
    search = os.pathsep.join([root, *filter(None, [os.environ.get("PYTHONPATH")])])
    return subprocess.Popen(
        [
            sys.executable,
            "-P",
            "-m",
            "controller.statistics_process",
            block_name,
            str(os.getpid()),
            str(recorder),
        ],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        start_new_session=True,
        env={**os.environ, "PYTHONPATH": search},
    )


def stop_statistics(process: subprocess.Popen[bytes], timeout_s: float = 3.0) -> None:
    """Ask it to end, and see that it does; may be called twice."""
    process.terminate()
    try:
        process.wait(timeout_s)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


class Statistics:
    """The differences from one second to the next. Pure: a block and the throttling in, fields out."""

    def __init__(self, block: LoopBlock) -> None:
        """Begin with what the block holds now."""
        self._block = block
        self._lateness, self._compute = block.lateness.counts(), block.compute.counts()
        self._cycles, self._misses, self._samples = block.cycles, block.misses, block.samples
        self._overruns, _ = block.overruns(block.cycles + 1)
        self._changes, _ = block.changes(block.cycles + 1)

    def line(self) -> dict[str, object]:
        """The fields of one line: counts since the last one, and percentiles of the cycles since then."""
        block = self._block
        lateness, compute = block.lateness.counts(), block.compute.counts()
        late = [now - was for now, was in zip(lateness, self._lateness, strict=True)]
        spent = [now - was for now, was in zip(compute, self._compute, strict=True)]
        cycles, misses, samples = block.cycles, block.misses, block.samples
        count, last = block.changes(max(0, block.changes(1 << 62)[0] - 1))
        self._changes = count
        fields: dict[str, object] = {
            "cycle": block.cycle,
            "cycles": cycles - self._cycles,
            "missed": misses - self._misses,
            "visual_samples": samples - self._samples,
            "accelerometer_faults": block.accelerometer_faults,
            "wakeup_latency_us": _percentiles(late),
            "compute_us": _percentiles(spent),
            "state": str(last[-1].state) if last else "",
            "reason": str(last[-1].reason or "") if last else "",
        }
        self._lateness, self._compute = lateness, compute
        self._cycles, self._misses, self._samples = cycles, misses, samples
        return fields

    def overruns(self, throttled: bool) -> dict[str, object] | None:
        """The fields of a warning about the overruns since the last call; None where there were none."""
        self._overruns, found = self._block.overruns(self._overruns)
        if not found:
            return None
        worst = max(found, key=lambda overrun: overrun.missed)
        causes = [_cause_of(overrun, throttled) for overrun in found]
        cause = _cause_of(worst, throttled)
        return {
            "overruns": len(found),
            "missed": sum(overrun.missed for overrun in found),
            "causes": {str(each): causes.count(each) for each in dict.fromkeys(causes)},
            "worst_cycle": worst.cycle,
            "worst_missed": worst.missed,
            "cause": str(cause),
            "remedy": REMEDY[cause],
            "counters": worst.counters._asdict(),
        }


def _cause_of(overrun: Overrun, throttled: bool) -> Cause:
    return overrun_cause(overrun.counters._replace(throttled=throttled))


def _percentiles(counts: list[int]) -> dict[str, float]:
    p50, p99, greatest = percentiles_us(counts, (0.5, 0.99, 1.0))
    return {"p50": p50, "p99": p99, "max": greatest}


class Throttling:
    """Whether a processor was slowed down: by its count of thermal events, or by its present clock."""

    def __init__(self, root: Path = Path("/sys/devices/system/cpu")) -> None:
        """Processors without such files are taken for never slowed down."""
        self._counts = sorted(root.glob("cpu[0-9]*/thermal_throttle/core_throttle_count"))
        self._clocks = sorted(root.glob("cpu[0-9]*/cpufreq"))
        self._last = self._events()

    def _events(self) -> int:
        return sum(_number(path) for path in self._counts)

    def seen(self) -> bool:
        """Since the last call, or now."""
        events = self._events()
        risen, self._last = events > self._last, events
        slow = any(
            0 < _number(clock / "scaling_cur_freq") < _SLOW * _number(clock / "cpuinfo_max_freq")
            for clock in self._clocks
        )
        return risen or slow


def _number(path: Path) -> int:
    try:
        return int(path.read_text())
    except (OSError, ValueError):
        return 0


def _runs(process: int) -> bool:
    """Whether a process is there and has not ended."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except (OSError, IndexError):
        return False


def main(block_name: str, loop_process: int, recorder: int) -> int:
    """Run until the loop has ended or is gone."""
    stop = StopSignal()
    with contextlib.suppress(OSError):
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        block = LoopBlock(block_name, create=False)
    except UserError as error:
        log(_PROCESS, "error", str(error))
        return 1
    statistics, throttling = Statistics(block), Throttling()
    due = time.monotonic() + _PERIOD_S
    recording = True
    while not (stop or block.ended) and os.getppid() == loop_process:
        time.sleep(_POLL_S)
        if time.monotonic() < due:
            continue
        due += _PERIOD_S
        if block.cycles:
            log(_PROCESS, "info", "loop", **statistics.line())
        if recording and not _runs(recorder) and not block.ended:
            recording = False
            log(_PROCESS, "error", "the recorder's process has ended", remedy=RECORDER_ENDED)
        if (warning := statistics.overruns(throttling.seen())) is not None:
            log(_PROCESS, "warning", "cycles missed", **warning)
    if os.getppid() != loop_process and not block.ended:
        log(_PROCESS, "error", "the loop is gone", **statistics.line())
        block.remove()
    block.close()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3])))
