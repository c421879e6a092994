"""A periodic force: the catalogue's, in frequency, size and phase."""

from math import pi, sin

import pytest

from tests.fixtures.shaken_arm import assert_acts_as


@pytest.mark.slow
def test_the_force_is_the_catalogues() -> None:
    assert_acts_as(
        {"cause": "periodic_disturbance", "frequency_hz": 4.1, "amplitude_m_s2": 0.9, "phase_rad": 0.7},
        lambda t, w, q, v: 0.9 * sin(2.0 * pi * 4.1 * t + 0.7),
    )
