"""A filter begun anew keeps what it must."""

import numpy as np
import pytest

from stillarm.controller.estimation.fused.filters.laws import FILTERS
from stillarm.controller.estimation.fused.filters.new_beginning import begin_near
from tests.fixtures.ringing_bank import ringing


def test_filters_that_begin_near_keep_the_vibration_and_the_images_zero_alone() -> None:
    filters, at = ringing()
    x = filters.x[3].copy()
    x[at.offset], x[at.force], x[at.shift], x[at.frequency] = 0.011, 0.02, 0.03, 0.4
    begin_near(filters, x)
    kept = np.zeros(at.size)
    kept[0], kept[1], kept[at.offset] = 0.004, -0.003, 0.011
    assert np.array_equal(filters.x, np.tile(kept, (FILTERS, 1)))
    first = filters.first[0]
    assert filters.p[0, 0, 0] == pytest.approx(0.25 * 0.005**2 + 0.01 * first[0])
    assert filters.p[0, at.shift, at.shift] == first[at.shift]
    assert np.count_nonzero(filters.p[0] - np.diag(np.diag(filters.p[0]))) == 0


def test_a_vibration_that_is_larger_than_the_first_guess_is_not_better_known_for_it() -> None:
    filters, _ = ringing()
    x = filters.x[0].copy()
    x[0] = 10.0
    begin_near(filters, x)
    assert filters.p[0, 0, 0] == filters.first[0, 0]
