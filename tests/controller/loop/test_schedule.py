"""The schedule's arithmetic: no burst after a stall, the number follows real time."""

import time
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stillarm.controller.loop.schedule import CycleClock, next_cycle


@given(last=st.integers(0, 10**7), late_cycles=st.floats(-1.0, 500.0))
def test_an_overrun_skips_whole_cycles(last: int, late_cycles: float) -> None:
    """Next cycle is later than the last, never wholly past, and what is skipped is counted."""
    now = (last + 1 + late_cycles) * 0.001
    due, missed = next_cycle(last, now, 0.001)
    assert due > last
    assert (due + 1) * 0.001 >= now - 1e-9
    assert missed == due - last - 1
    if late_cycles < 1.0:
        assert missed == 0 or late_cycles > 0.999


@given(
    delays=st.lists(st.one_of(st.floats(0.0, 0.9), st.floats(0.0, 50.0)), min_size=1, max_size=60),
    overslept=st.floats(0.0, 0.3),
)
def test_no_row_of_stalls_makes_a_burst_or_shifts_the_schedule(delays: list[float], overslept: float) -> None:
    """Each cycle takes `delays` of a cycle, each sleep ends a little late: cycles begin no earlier than they are due,
    the number follows the clock, and run and missed cycles add up.
    """
    patch = pytest.MonkeyPatch()
    now = [100.0]

    def sleep(seconds: float) -> None:
        now[0] += seconds + overslept * 0.001

    patch.setattr(time, "monotonic", lambda: now[0])
    patch.setattr(time, "sleep", sleep)
    try:
        clock = CycleClock(0.001, 100.0)
        cycle = clock.start()
        began, first = [(cycle, now[0])], cycle
        for delay in delays:
            now[0] += delay * 0.001
            cycle = clock.wait(cycle)
            began.append((cycle, now[0]))
    finally:
        patch.undo()
    for number, at in began:
        late = at - 100.0 - number * 0.001
        assert -1e-9 <= late < 0.001 + 1e-9
    numbers = [number for number, _ in began]
    assert all(after > before for before, after in pairwise(numbers))
    assert cycle - first == len(delays) + clock.misses
