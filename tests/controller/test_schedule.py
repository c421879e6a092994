"""The schedule's arithmetic: no burst after a stall, the number follows real time."""

from hypothesis import given
from hypothesis import strategies as st

from controller.schedule import next_cycle


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
