"""Rows that are missing here and there are no clock that was set."""

import pytest

from stillarm.diagnosis.data.measured import ClockGap
from stillarm.diagnosis.sensors.clocks import _one_of_many

LOST = tuple(ClockGap(100 * i, 0.001 * (1 + i % 2)) for i in range(1, 9))


@pytest.mark.parametrize(("extra_s", "many"), [(0.001, True), (0.003, True), (0.08, False)])
def test_a_gap_as_long_as_the_others_is_lost_rows(extra_s: float, many: bool) -> None:
    gap = ClockGap(1000, extra_s)
    assert _one_of_many(gap, (*LOST, gap)) is many
    assert not _one_of_many(gap, (*LOST[:2], gap))
