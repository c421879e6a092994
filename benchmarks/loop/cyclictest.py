"""cyclictest of the rt-tests, if installed: a second floor, in C."""

import re
import shutil
import subprocess

from stillarm.benchmarks.loop.slices import Measured
from stillarm.controller.loop.realtime import PRIORITY

_LONGEST_US = 20_000


def installed() -> bool:
    """Whether cyclictest is installed."""
    return shutil.which("cyclictest") is not None


def command(duration_s: float, cycle_s: float, processor: int, fifo: bool) -> list[str]:
    """cyclictest's command line for one slice. fifo: whether SCHED_FIFO is allowed."""
    return [
        *("cyclictest", "--quiet", "--mlockall", f"--interval={round(cycle_s * 1e6)}"),
        *(f"--loops={round(duration_s / cycle_s)}", f"--affinity={processor}", f"--histogram={_LONGEST_US}"),
        *((f"--priority={PRIORITY}", "--policy=fifo") if fifo else ("--policy=other",)),
    ]


def add_histogram(text: str, measured: Measured, cycle_s: float) -> None:
    """Add the printed histogram, lines of microseconds and counts, to the measurement.

    A wake-up later than a cycle counts its whole cycles as missed, as in the loop.
    """
    cycle_us = cycle_s * 1e6
    for late, count in re.findall(r"^(\d{6}) (\d+)\s*$", text, re.MULTILINE):
        for _ in range(int(count)):
            measured.lateness.add(int(late) * 1e-6)
        measured.cycles += int(count)
        measured.misses += int(count) * int(int(late) / cycle_us)
    for over in re.findall(r"^# Histogram Overflows: (\d+)", text, re.MULTILINE):
        for _ in range(int(over)):
            measured.lateness.add(_LONGEST_US * 1e-6)
        measured.cycles += int(over)
        measured.misses += int(over) * int(_LONGEST_US / cycle_us)


def run_slice(measured: Measured, duration_s: float, cycle_s: float, processor: int, fifo: bool) -> None:
    """Run one slice. If cyclictest cannot run, nothing is added."""
    words = command(duration_s, cycle_s, processor, fifo)
    done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=duration_s + 10.0)
    if done.returncode == 0:
        add_histogram(done.stdout, measured, cycle_s)
