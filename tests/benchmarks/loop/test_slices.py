"""Slices of a measurement, in turns."""

import time

import pytest

from stillarm.benchmarks.loop.slices import Measured, run_slice
from stillarm.controller.loop.schedule import CycleClock


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
