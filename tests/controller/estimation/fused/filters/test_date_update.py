"""What arrivals tell one filter alone."""

import numpy as np
import pytest

from stillarm.controller.estimation.fused.filters.date_update import (
    begin_late,
    doubt_lateness,
    place,
    update_by_arrival,
)
from stillarm.controller.estimation.fused.filters.laws import FILTERS, LAWS, Law
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


@pytest.mark.parametrize(("doubted", "least_s", "most_s"), [(True, 0.0, 1e-4), (False, 1e-3, 0.014)])
def test_a_new_supervisors_arrivals_move_no_clock(doubted: bool, least_s: float, most_s: float) -> None:
    """Its images come 14 ms sooner; shift and mean delay were known to 0.5 and 1 ms. In a demo the clock was moved by
    5 ms, and the estimate stayed wrong by 6 % of the amplitude with 0.7 % stated."""
    filters, at = ringing()
    t, late = at.shift, at.late
    for state, std_s in ((t, 0.5e-3), (late, 1e-3)):
        filters.p[0, state, :] = filters.p[0, :, state] = 0.0
        filters.p[0, state, state] = std_s**2
    filters.x[0, t] = filters.x[0, late] = 0.0
    others = filters.p[LAWS - 1, t, t]
    if doubted:
        doubt_lateness(filters, 0.03**2, 0.0064**2)
        assert filters.p[LAWS - 1, t, t] == pytest.approx(others + 0.0064**2)
    update_by_arrival(filters, np.full(FILTERS, -0.014), np.full(FILTERS, 1e-6), np.zeros(FILTERS))
    assert least_s <= abs(float(filters.x[0, t])) < most_s
