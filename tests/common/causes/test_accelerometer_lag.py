"""A lag shifts the signal."""

from math import pi

import numpy as np
import pytest

from tests.fixtures.felt import TIMES, sensed


def test_a_lag_shifts_the_signal() -> None:
    found = sensed({"cause": "accelerometer_lag", "delay_s": 0.0125})
    wanted = -1.5 * 2.0 * np.cos(2.0 * pi * 2.6 * (TIMES - 0.0125)) + 0.2
    assert found[30:] == pytest.approx(wanted[30:], abs=1e-6)
