"""Gravity shows with the tip's angle."""

import pytest

from tests.fixtures.felt import ANGLE, PLAIN, sensed


def test_it_is_what_the_catalogue_says() -> None:
    effect = {"cause": "gravity_leakage", "gain_m_s2_per_rad": 9.0}
    assert sensed(effect) == pytest.approx(PLAIN + 9.0 * ANGLE, abs=1e-12)
