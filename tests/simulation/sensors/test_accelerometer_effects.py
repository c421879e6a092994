"""The accelerometer's effects together: the noise stays as it is."""

from typing import Any

import numpy as np
import pytest

from tests.fixtures.felt import TIMES, sensed


def test_effects_leave_the_noise_alone_and_no_size_is_no_effect() -> None:
    """The same noise with and without; to the bit at size zero."""
    plain = sensed(noise=0.5)
    none: list[dict[str, Any]] = [
        {"cause": "accelerometer_bias_drift", "rate_m_s3": 0.0},
        {"cause": "accelerometer_sensitivity_drift", "rate_per_s": 0.0},
        {"cause": "gravity_leakage", "gain_m_s2_per_rad": 0.0},
        {"cause": "mains_hum", "frequency_hz": 50.0, "amplitude_m_s2": 0.0},
        {"cause": "impulse_noise", "rate_hz": 0.0, "amplitude_m_s2": 5.0},
        {"cause": "accelerometer_lag", "delay_s": 0.0},
    ]
    assert np.array_equal(sensed(*none, noise=0.5), plain)
    drifting = sensed({"cause": "accelerometer_bias_drift", "rate_m_s3": 0.5}, noise=0.5)
    assert drifting - plain == pytest.approx(0.5 * TIMES, abs=1e-12)
