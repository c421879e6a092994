"""Forces told to the filters: only the quiet ones, what the image zero gives, and their end."""

import numpy as np
import pytest

from stillarm.controller.estimation.fused.accelerometer.blocks import Jump
from stillarm.controller.estimation.fused.filters.jumps import end_force, give_force, inflate, let_scale_walk
from stillarm.controller.estimation.fused.filters.laws import DISTURBED, LAWS, QUIET
from tests.fixtures.ringing_bank import bank, check_covariances, ringing


def test_only_the_quiet_filters_are_told_of_a_force_that_images_show() -> None:
    filters, at = ringing()
    before = filters.p.copy()
    inflate(filters, Jump(0.3, (0.0,), (0.0,), 0.01), QUIET)
    give_force(filters, 0.002)
    assert np.all(filters.p[QUIET, at.force, at.force] > 0.01**2)
    assert np.array_equal(filters.p[DISTURBED], before[DISTURBED])
    assert np.allclose(filters.x[QUIET, at.force], 0.002) and not filters.x[DISTURBED, at.force].any()


def test_a_given_force_takes_from_the_images_zero_what_it_gets() -> None:
    """Images show the sum of both: neither it nor its variance changes."""
    filters, at = ringing()
    filters.x[:, at.offset], filters.p[:, at.offset, at.offset] = 0.007, 1e-9
    row = np.zeros(at.size)
    row[at.offset] = row[at.force] = 1.0
    give_force(filters, 0.005)
    assert filters.x[QUIET, at.offset] == pytest.approx([0.002] * LAWS)
    assert filters.x[QUIET] @ row == pytest.approx([0.007] * LAWS)
    assert np.vecdot(filters.p[QUIET] @ row, row) == pytest.approx([1e-9] * LAWS, rel=1e-6)


def test_the_end_of_a_force_is_taken_in_as_a_measurement_of_zero() -> None:
    """Against the conditional mean and covariance of a normal law; what is correlated with the force moves with it."""
    filters, at = ringing()
    inflate(filters, Jump(0.1, (0.0,), (0.0,), 0.01), QUIET)
    filters.x[QUIET, at.force] = 0.003
    x, p, f = filters.x[0].copy(), filters.p[0].copy(), at.force
    end_force(filters)
    rest = [i for i in range(at.size) if i != f]
    assert np.allclose(filters.x[0, rest], (x - p[:, f] / p[f, f] * x[f])[rest], atol=1e-15)
    wanted = p - np.outer(p[:, f], p[:, f]) / p[f, f]
    assert np.allclose(filters.p[0][np.ix_(rest, rest)], wanted[np.ix_(rest, rest)], atol=1e-15)
    assert abs(filters.x[0, 0] - x[0]) > 1e-4


def test_a_scale_that_walks_leaves_the_place_where_the_joint_holds_the_tip() -> None:
    """Images show the place as before; what vibrates about it, and another place, by a scale that may have changed."""
    filters, at = bank()
    held_m, walked = 0.4, 0.02**2
    here, home, scale = (
        filters.zero_variance(1, held_m),
        filters.zero_variance(1, 0.0),
        filters.p[1, at.scale, at.scale],
    )
    let_scale_walk(filters, walked, held_m)
    assert filters.zero_variance(1, held_m) == pytest.approx(here, rel=1e-9)
    assert filters.zero_variance(1, 0.0) == pytest.approx(home + walked * held_m**2, rel=1e-9)
    assert filters.p[1, at.scale, at.scale] == pytest.approx(scale + walked)
    check_covariances(filters)
