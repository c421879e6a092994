"""The loop's benchmark: what it adds up, and what it asks for. No timing of this machine is judged here."""

import secrets
import time

import pytest

from stillarm.benchmarks.loop import cyclictest
from stillarm.benchmarks.loop.latency import run as run_latency
from stillarm.benchmarks.loop.run import Window, verdict
from stillarm.benchmarks.loop.slices import Measured, run_slice
from stillarm.controller.loop.schedule import CycleClock
from stillarm.controller.safety.table import State
from stillarm.controller.statistics.loop_block import LoopBlock

# as cyclictest 2.4 prints it
HISTOGRAM = """# /dev/cpu_dma_latency set to 0us
# Histogram
000000 000000
000003 000090
000012 000009
002500 000001
# Total: 000000100
# Min Latencies: 00003
# Histogram Overflows: 00002
# Histogram Overflow at cycle number:
# Thread 0: 00120
"""


def test_cyclictest_histogram_is_taken_in() -> None:
    """Counts, what lies beyond the histogram, and cycles wholly passed as missed."""
    measured = Measured()
    cyclictest.add_histogram(HISTOGRAM, measured, 0.001)
    assert measured.cycles == 102
    assert measured.misses == 2 + 2 * 20
    result = measured.result()
    assert result["wakeup_latency_us"]["p50"] == pytest.approx(3.0, abs=1.0)
    assert result["wakeup_latency_us"]["max"] == pytest.approx(20_000.0)


def test_cyclictest_that_prints_nothing_measures_nothing() -> None:
    """As where it is not allowed to run."""
    measured = Measured()
    cyclictest.add_histogram("", measured, 0.001)
    assert measured.cycles == 0


def test_a_slice_runs_its_cycles_and_its_work() -> None:
    """Run and missed cycles make up the slice; the work's time is counted once a cycle, and not without work."""
    calls: list[int] = []
    with_work, without = Measured(), Measured()
    run_slice(with_work, 0.05, 0.001, lambda: calls.append(1))
    run_slice(without, 0.05, 0.001)
    for measured in (with_work, without):
        assert 0 < measured.cycles <= 50
        assert measured.cycles + measured.misses >= 50
        assert sum(measured.lateness.counts()) == measured.cycles
    assert len(calls) == with_work.cycles == sum(with_work.compute.counts())
    assert sum(without.compute.counts()) == 0


def test_a_slice_that_starts_late_is_no_shorter(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its first cycles are not lost without being run or missed."""
    start = CycleClock.start

    def late(clock: CycleClock) -> int:
        time.sleep(0.02)
        return start(clock)

    monkeypatch.setattr(CycleClock, "start", late)
    measured = Measured()
    run_slice(measured, 0.05, 0.001)
    assert measured.cycles + measured.misses >= 50


def test_a_window_counts_from_when_it_was_opened() -> None:
    """What came before, start-up among it, is left out: the greatest, too."""
    block = LoopBlock(f"test-window-{secrets.token_hex(4)}", create=True)
    try:
        block.end_cycle(0, 0.5, 0.4, 0, State.ARMED, None)
        block.note_overrun(0, 500, (0.001, 0.5, 0.0, 0.0), (0, 0, 0, 0, 0))
        window = Window(block)
        for cycle in range(501, 601):
            block.end_cycle(cycle, 30e-6, 100e-6, 0, State.ARMED, None)
        block.note_overrun(600, 2, (0.001, 0.0, 0.0, 0.0), (0, 0, 0, 0, 0))
        result = window.result()
        assert (result["cycles"], result["deadline_misses"]) == (100, 2)
        assert result["wakeup_latency_us"]["max"] == pytest.approx(30.0)
        assert window.compute_us()["p99"] == pytest.approx(100.0, abs=1.0)
    finally:
        block.close()


def test_the_verdict_is_the_one_that_is_asked_for() -> None:
    """1.5 times the floor's 99th percentile; 1.5 m + 3 sqrt(m) + 3 misses; 300 us."""

    def result(p99: float, misses: int, compute: float) -> dict[str, object]:
        loop = {"wakeup_latency_us": {"p99": p99}, "deadline_misses": misses}
        floor = {"wakeup_latency_us": {"p99": 40.0}, "deadline_misses": 4}
        return {"loop": loop, "floor": floor, "compute_us": {"p99": compute}}

    assert [row["kept"] for row in verdict(result(60.0, 15, 300.0))] == ["yes", "yes", "yes"]
    assert [row["kept"] for row in verdict(result(60.1, 16, 300.1))] == ["no", "no", "no"]


def test_latency_has_the_names_of_the_file() -> None:
    """A tenth of a second; what this machine gives is not judged."""
    result = run_latency(0.1)
    for name in ("loop", "floor"):
        assert set(result[name]) == {"wakeup_latency_us", "deadline_misses", "cycles"}
        assert set(result[name]["wakeup_latency_us"]) == {"p50", "p99", "p999", "max"}
        assert result[name]["cycles"] > 0
    assert set(result["compute_us"]) == {"p50", "p99", "p999", "max"}
