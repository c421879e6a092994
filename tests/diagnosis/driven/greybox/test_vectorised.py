"""Sums and products against the mathematics library."""

import numpy as np
import pytest

from stillarm.diagnosis.driven.greybox.vectorised import faded, sine_cosine


def test_what_fades_with_the_square() -> None:
    for ratio in np.concatenate([np.linspace(-6.0, 6.0, 401), [40.0, 1e100]]):
        assert faded(ratio) == pytest.approx(np.exp(-ratio * ratio), rel=1e-12, abs=1e-17)


def test_sine_and_cosine_in_every_quarter() -> None:
    for angle in np.concatenate([np.linspace(-20.0, 20.0, 4001), [0.0, 1e3, -1e5, 123456.789]]):
        assert sine_cosine(angle) == pytest.approx((np.sin(angle), np.cos(angle)), rel=0.0, abs=1e-13)


def test_an_angle_that_has_run_away_is_no_more_than_a_wrong_one() -> None:
    assert np.abs(sine_cosine(1e300)).max() <= 1.0
