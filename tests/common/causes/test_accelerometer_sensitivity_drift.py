"""The scale moves evenly."""

import pytest

from tests.fixtures.felt import TIMES, TRUE, sensed


def test_it_is_what_the_catalogue_says() -> None:
    effect = {"cause": "accelerometer_sensitivity_drift", "rate_per_s": 0.1}
    assert sensed(effect) == pytest.approx(-1.5 * (1.0 + 0.1 * TIMES) * TRUE + 0.2, abs=1e-12)
