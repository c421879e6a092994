"""The demo's judges on a decaying sine that is known exactly."""

import numpy as np
import pytest

from stillarm.simulation.demo.ring_down import (
    decay_rate_per_s,
    envelope_m,
    fitted_settling_time_s,
    settling_time_s,
)

STEP = 0.001
T = np.arange(0.0, 30.0, STEP)


@pytest.mark.parametrize("ratio", [0.01, 0.05, 0.12])
def test_rate_and_settling_time(ratio: float) -> None:
    """exp(-ratio w t): the rate, and the time to 5 %."""
    rate = ratio * 2 * np.pi * 2.6
    q = 0.006 * np.exp(-rate * T) * np.cos(2 * np.pi * 2.6 * np.sqrt(1 - ratio**2) * T)
    envelope = envelope_m(q, STEP, 2.6)
    assert decay_rate_per_s(envelope, STEP, 0.006, 0.3) == pytest.approx(rate, rel=0.03)
    settled = settling_time_s(envelope, STEP, 0.006)
    assert settled == pytest.approx(np.log(20) / rate, rel=0.05)
    assert fitted_settling_time_s(rate) == pytest.approx(np.log(20) / rate)


def test_what_does_not_settle_says_so() -> None:
    """None, not a number."""
    q = 0.006 * np.cos(2 * np.pi * 2.6 * T)
    assert settling_time_s(envelope_m(q, STEP, 2.6), STEP, 0.006) is None
    assert fitted_settling_time_s(-0.1) is None
