"""A sine is added."""

import numpy as np
import pytest

from tests.fixtures.felt import PLAIN, TIMES, sensed


def test_it_is_what_the_catalogue_says() -> None:
    effect = {"cause": "mains_hum", "frequency_hz": 50.0, "amplitude_m_s2": 0.5, "phase_rad": 0.3}
    assert sensed(effect) == pytest.approx(PLAIN + 0.5 * np.sin(2.0 * np.pi * 50.0 * TIMES + 0.3), abs=1e-12)
