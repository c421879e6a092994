"""The loop's statistics, once a second: a separate process reads the shared block and writes to the log.

Start it with start_statistics(). It ends with the loop, however the loop ends.
"""

import contextlib
import gc
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from stillarm.common.files.configuration import Telemetry
from stillarm.common.process.child_process import next_line, start_module, stop_process
from stillarm.common.process.service_notify import Watchdog
from stillarm.common.process.stop_signal import StopSignal
from stillarm.common.recorder.structured_log import log, log_line
from stillarm.common.recorder.telemetry import telemetry_sender
from stillarm.common.user_error import UserError
from stillarm.controller.input.plausible_input import Field
from stillarm.controller.statistics.histogram import percentiles_us
from stillarm.controller.statistics.loop_block import LoopBlock, Overrun
from stillarm.controller.statistics.loop_report import loop_report
from stillarm.controller.statistics.overrun import REMEDY, OverrunCounters, overrun_cause
from stillarm.controller.statistics.processor_watch import Stolen, Throttling

RECORDER_ENDED = (
    "damping continues; nothing more is recorded or sent as telemetry until the controller restarts; "
    "repair the recording with `stillarm recover`"
)
REFUSED_REMEDY = (
    "they count as missing; look for the device or the link that sends them, and compare the model's [accelerometer] "
    "range_m_s2, [drive] limits and [camera] scales, which define what is plausible, with the rig"
)
_PERIOD_S = 1.0
_POLL_S = 0.1
_PROCESS = "controller"
_LOADED = "loaded"
_LOADED_WITHIN_S = 20.0
_ENDS_WITHIN_S = 3.0


def start_statistics(
    block_name: str, recorder: int, telemetry: Telemetry | None = None
) -> subprocess.Popen[bytes]:
    """Start it for this process's block, in a separate session that Ctrl-C does not reach.

    recorder: process id of the recorder, whose end it reports. telemetry: where a panel may listen.
    """
    panel = (telemetry.host, str(telemetry.panel_port)) if telemetry is not None and telemetry.enabled else ()
    return start_module(
        "stillarm.controller.statistics.statistics_process",
        block_name,
        str(os.getpid()),
        str(recorder),
        *panel,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        start_new_session=True,
    )


def wait_until_loaded(process: subprocess.Popen[bytes]) -> None:
    """Wait until it has warmed up, so that its start takes no processor time from the first cycles.

    If it ends instead, it has reported why, and the loop continues without it.
    """
    next_line(process, _LOADED_WITHIN_S)
    assert process.stdout is not None
    process.stdout.close()


def stop_statistics(process: subprocess.Popen[bytes]) -> None:
    """Ask it to end, and wait for it; may be called twice."""
    stop_process(process, _ENDS_WITHIN_S)


class Statistics:
    """The differences from one second to the next. Pure: takes a block and the throttling, returns fields."""

    def __init__(self, block: LoopBlock) -> None:
        """Start from the present contents of the block."""
        self._block = block
        self._lateness, self._compute = block.lateness.counts(), block.compute.counts()
        self._cycles, self._misses, self._samples = block.cycles, block.misses, block.samples
        self._overruns, _ = block.overruns(block.cycles + 1)
        self._missed_before = block.misses
        self._changes, _ = block.changes(block.cycles + 1)
        self._refused = block.refused
        self.report = b""
        """The last line's second, for the panel."""

    def line(self) -> dict[str, object]:
        """The fields of one line: counts and percentiles since the last line."""
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
        self.report = loop_report(block.cycle, late, spent, cycles - self._cycles, misses - self._misses)
        self._lateness, self._compute = lateness, compute
        self._cycles, self._misses, self._samples = cycles, misses, samples
        return fields

    def overruns(self, throttled: bool, stolen_s: float) -> dict[str, object] | None:
        """The fields of a warning about the overruns since the last call; None without overruns.

        throttled, stolen_s: state of the processor in that time. Among very many overruns, only the last have causes.
        """
        count, found = self._block.overruns(self._overruns)
        if not found:
            return None
        new, self._overruns = count - self._overruns, count
        misses = self._block.misses
        missed, self._missed_before = misses - self._missed_before, misses
        worst = max(found, key=lambda overrun: overrun.missed)

        def seen(overrun: Overrun) -> OverrunCounters:
            return overrun.counters._replace(throttled=throttled, stolen_s=stolen_s)

        causes = [overrun_cause(seen(overrun)) for overrun in found]
        cause = overrun_cause(seen(worst))
        return {
            "overruns": new,
            "missed": missed,
            "causes": {str(each): causes.count(each) for each in dict.fromkeys(causes)},
            "worst_cycle": worst.cycle,
            "worst_missed": worst.missed,
            "cause": str(cause),
            "remedy": REMEDY[cause],
            "counters": seen(worst)._asdict(),
        }

    def refused(self) -> dict[str, object] | None:
        """The fields of a warning about the values refused since the last call; None without refused values."""
        counts, before = self._block.refused, self._refused
        self._refused = counts
        new = {
            field.name.lower(): now - was
            for field, now, was in zip(Field, counts, before, strict=True)
            if now > was
        }
        return {"values": new, "remedy": REFUSED_REMEDY} if new else None


def _percentiles(counts: list[int]) -> dict[str, float]:
    p50, p99, greatest = percentiles_us(counts, (0.5, 0.99, 1.0))
    return {"p50": p50, "p99": p99, "max": greatest}


def _runs(process: int) -> bool:
    """Whether a process exists and has not ended."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except (OSError, IndexError):
        return False


def _still_records(recorder: int, block: LoopBlock, loop_process: int) -> bool:
    """Whether the recorder runs. Logs an error if it has ended before the loop; after the loop it ends by itself."""
    if _runs(recorder) or block.ended or os.getppid() != loop_process:
        return True
    log(_PROCESS, "error", "the recorder's process has ended", remedy=RECORDER_ENDED)
    return False


def _warm_up(block: LoopBlock, throttling: Throttling, stolen: Stolen) -> None:
    """Make one line and one warning from the block and discard them; then report that everything is loaded."""
    statistics = Statistics(block)
    log_line(_PROCESS, "info", "loop", time.time(), **statistics.line())
    statistics.overruns(throttling.seen(), stolen.passed_s())
    gc.freeze()
    with contextlib.suppress(OSError):  # nobody may be waiting
        print(_LOADED, flush=True)


def main(block_name: str, loop_process: int, recorder: int, panel: tuple[str, int] | None = None) -> int:
    """Run until the loop has ended or is gone. panel: host and port of who may listen to each second's report."""
    send = telemetry_sender(*panel) if panel is not None else None
    stop = StopSignal()
    with contextlib.suppress(OSError):
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        block = LoopBlock(block_name, create=False)
    except UserError as error:
        log(_PROCESS, "error", str(error))
        return 1
    statistics, throttling, stolen = Statistics(block), Throttling(), Stolen(loop_process)
    watchdog = Watchdog()  # in addition to the recorder's, which may be lost without harm to the damping
    _warm_up(block, throttling, stolen)
    due = time.monotonic() + _PERIOD_S
    recording = True
    while not (stop or block.ended):
        time.sleep(_POLL_S)
        if os.getppid() != loop_process:
            break
        watchdog.feed(block.cycles, time.monotonic())
        if time.monotonic() < due:
            continue
        due += _PERIOD_S
        if block.cycles:
            log(_PROCESS, "info", "loop", **statistics.line())
            if send is not None:
                send(statistics.report)
        recording = recording and _still_records(recorder, block, loop_process)
        if (warning := statistics.overruns(throttling.seen(), stolen.passed_s())) is not None:
            log(_PROCESS, "warning", "cycles missed", **warning)
        if (refusals := statistics.refused()) is not None:
            log(_PROCESS, "warning", "values refused", **refusals)
    if os.getppid() != loop_process and not block.ended:
        log(_PROCESS, "error", "the loop is gone", **statistics.line())
        block.remove()
    block.close()
    return 0


if __name__ == "__main__":
    block_name, loop_process, recorder, *panel = sys.argv[1:]
    listener = (panel[0], int(panel[1])) if panel else None
    sys.exit(main(block_name, int(loop_process), int(recorder), listener))
