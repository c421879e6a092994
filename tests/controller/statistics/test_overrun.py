"""The likely cause of an overrun, case by case."""

import mmap
import time

import pytest

from stillarm.controller.statistics.overrun import (
    REMEDY,
    OverrunCause,
    OverrunCounters,
    ThreadCounters,
    overrun_cause,
)

CYCLE_S = 0.001


def seen(**changes: object) -> OverrunCounters:
    """An overrun in which the controller computed for 1.5 ms, unless told otherwise."""
    quiet = OverrunCounters(CYCLE_S, late_s=2e-5, device_s=1e-4, computing_s=1.5e-3)
    return quiet._replace(**changes)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("counters", "cause"),
    [
        (seen(), OverrunCause.OWN_COMPUTING),
        (seen(throttled=True), OverrunCause.THROTTLING),
        (seen(major_faults=1), OverrunCause.PAGE_FAULT),
        (seen(major_faults=1, late_s=0.01, throttled=True), OverrunCause.PAGE_FAULT),
        (seen(minor_faults=2000), OverrunCause.PAGE_FAULT),
        (seen(minor_faults=3), OverrunCause.OWN_COMPUTING),
        (seen(late_s=0.004, computing_s=2e-4), OverrunCause.NO_CPU),
        (seen(run_delay_s=0.0012), OverrunCause.NO_CPU),
        (seen(involuntary_switches=1), OverrunCause.NO_CPU),
        (seen(device_s=0.003, computing_s=2e-4), OverrunCause.SLOW_BUS),
        (seen(device_s=0.003, computing_s=2e-4, run_delay_s=0.0028), OverrunCause.NO_CPU),
        (seen(device_s=0.003, computing_s=2e-4, stolen_s=0.01), OverrunCause.NO_CPU),
        (seen(device_s=0.03, computing_s=2e-4, stolen_s=0.01), OverrunCause.SLOW_BUS),
        (seen(voluntary_switches=1000), OverrunCause.OWN_COMPUTING),
    ],
)
def test_the_most_certain_evidence_counts(counters: OverrunCounters, cause: OverrunCause) -> None:
    """One row for each branch, and for evidence that contradicts."""
    assert overrun_cause(counters) is cause


def test_every_cause_has_a_remedy() -> None:
    """Something to do."""
    assert all(REMEDY[cause] for cause in OverrunCause)


def test_the_counters_move_with_what_this_thread_does() -> None:
    """New pages are faults, a sleep is a switch; nothing is negative, and the second reading starts from
    zero.
    """
    counters = ThreadCounters()
    counters.moved()
    with mmap.mmap(-1, 16 << 20) as pages:  # a bytearray may get pages that the process has touched before
        for page in range(0, len(pages), 4096):
            pages[page] = 1
        time.sleep(0.001)
        faults, _, switches, _, waited = counters.moved()
    assert faults > 0
    assert switches >= 1
    assert waited >= 0
    assert counters.moved()[0] <= faults
    counters.close()
    counters.close()
