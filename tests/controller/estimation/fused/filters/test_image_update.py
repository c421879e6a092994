"""When an image tells an instant, and what it counts where it tells none."""

import numpy as np
import pytest

from stillarm.controller.estimation.fused.arm.layout import Layout
from stillarm.controller.estimation.fused.filters.bank import FilterBank
from stillarm.controller.estimation.fused.filters.image_update import update_by_image
from stillarm.controller.estimation.fused.filters.laws import FILTERS
from tests.fixtures.ringing_bank import IMAGE_M2, bank, look


def told_of_the_shift(filters: FilterBank, at: Layout, joint_rate: float, variance: float) -> float:
    """By how much an image moves the shift of the first filter, s."""
    before = float(filters.x[0, at.shift])
    innovation = look(filters, 0.01, joint_rate, variance)
    update_by_image(filters, innovation, np.ones(FILTERS), None)
    return abs(float(filters.x[0, at.shift]) - before)


def test_a_rate_within_its_own_noise_tells_no_instant_while_the_shift_is_unknown() -> None:
    """An arm at rest, its joint moved by the encoder's noise alone; a joint that truly moves does tell."""
    for joint_rate, std, told in ((0.05, 0.1, False), (0.05, 0.0005, True)):
        filters, at = bank()
        filters.p[:, 0, 0] = filters.p[:, 1, 1] = 1e-12
        assert (told_of_the_shift(filters, at, joint_rate, std * std) > 0.0) == told


def test_a_shift_that_images_have_told_is_not_given_up_for_a_noisy_rate() -> None:
    filters, at = bank()
    filters.p[:, 0, 0] = filters.p[:, 1, 1] = 1e-12
    filters.p[:, at.shift, at.shift] = 0.2 * filters.first[:, at.shift]
    innovation = look(filters, 0.01, 0.05, 0.1**2)
    assert np.all(np.abs(innovation.ph[:, at.shift]) > 0.0)


def test_an_unseen_instant_still_counts_in_the_innovations_variance() -> None:
    """Of an image of which nothing else is unknown: its noise, and the rate's square, as known, by the instant's."""
    filters, at = bank()
    filters.p[:] = 0.0
    shift = filters.p[:, at.shift, at.shift] = filters.first[:, at.shift]
    innovation = look(filters, 0.0, 0.05, 0.1**2)
    assert not innovation.ph.any()
    wanted = IMAGE_M2 + (0.05**2 + 0.1**2) * (shift + filters.jitter)
    assert innovation.variance == pytest.approx(wanted, rel=1e-6)
