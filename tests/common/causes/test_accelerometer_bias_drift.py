"""The bias moves evenly."""

import pytest

from tests.fixtures.felt import PLAIN, TIMES, sensed


def test_it_is_what_the_catalogue_says() -> None:
    effect = {"cause": "accelerometer_bias_drift", "rate_m_s3": -0.04}
    assert sensed(effect) == pytest.approx(PLAIN - 0.04 * TIMES, abs=1e-12)
