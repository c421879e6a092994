"""What arrivals tell one filter alone."""

import numpy as np
import pytest

from stillarm.controller.estimation.fused.filters.date_update import begin_late, place
from stillarm.controller.estimation.fused.filters.laws import Law
from tests.fixtures.ringing_bank import act, ringing


def test_place_forgets_what_arrivals_told_of_one_filter_alone() -> None:
    filters, at = ringing()
    act(filters, at, "arrival", 0.01)
    x, p = filters.x.copy(), filters.p.copy()
    place(filters, int(Law.CLOCK), 0.042)
    t, late = at.shift, at.late
    assert (filters.x[0, t], filters.x[0, late]) == (0.042, 0.0)
    assert filters.p[0, t, t] == filters.first_variance(0, t)
    assert filters.p[0, t, late] == filters.p[0, late, t] == 0.0
    assert np.array_equal(filters.x[1:], x[1:]) and np.array_equal(filters.p[1:], p[1:])


def test_a_mean_delay_begun_late_explains_the_arrivals_and_leaves_the_shift() -> None:
    filters, at = ringing()
    filters.x[1, at.shift] = 0.004
    begin_late(filters, 1, 0.0215)
    assert filters.x[1, at.shift] == 0.004
    assert filters.x[1, at.shift] + filters.x[1, at.late] == pytest.approx(0.0215)
    assert filters.p[1, at.late, at.late] == 0.1**2
    assert filters.p[1, at.late, at.shift] == 0.0
