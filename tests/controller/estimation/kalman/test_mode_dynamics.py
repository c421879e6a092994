"""Motion of a mode between two times, against the matrix exponential."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from stillarm.common.files.model import Mode
from stillarm.controller.estimation.kalman.mode_dynamics import ModeDynamics

modes = st.builds(
    Mode, frequency_hz=st.floats(0.2, 60.0), damping_ratio=st.one_of(st.just(0.0), st.floats(0.0, 0.7))
)


def van_loan(dynamics: np.ndarray, noise: np.ndarray, elapsed_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Transition and added covariance by one matrix exponential (IEEE Trans. Automatic Control 23, 1978)."""
    n = len(dynamics)
    block = np.block([[-dynamics, noise], [np.zeros((n, n)), dynamics.T]]) * elapsed_s
    whole = expm(block)
    phi = whole[n:, n:].T
    return phi, phi @ whole[:n, n:]


@given(mode=modes, elapsed_s=st.floats(1e-4, 0.4))
@settings(max_examples=80, derandomize=True)
def test_mode_dynamics_are_exact(mode: Mode, elapsed_s: float) -> None:
    """Transition and scatter, for any damping, zero too."""
    w, zeta = 2 * pi * mode.frequency_hz, mode.damping_ratio
    if w * elapsed_s > 20.0:  # where van Loan's growing exponential has lost its digits
        elapsed_s = 20.0 / w
    phi, added = van_loan(np.array([[0.0, 1.0], [-w * w, -2 * zeta * w]]), np.diag([0.0, 1.0]), elapsed_s)
    dynamics = ModeDynamics(mode)
    got, scatter = dynamics.transition(elapsed_s), dynamics.scatter(elapsed_s)
    scale = np.array([[1.0, 1 / w], [w, 1.0]])
    assert np.reshape(got, (2, 2)) == pytest.approx(phi, abs=1e-9 * np.max(scale) * np.exp(0.5))
    assert scatter.vv == pytest.approx(added[1, 1], rel=1e-6)
    assert scatter.qv == pytest.approx(added[0, 1], rel=1e-5, abs=1e-9 * added[1, 1] / w)
    assert scatter.qq == pytest.approx(added[0, 0], rel=1e-5, abs=1e-9 * added[1, 1] / (w * w))
    back = np.reshape(dynamics.transition(-elapsed_s), (2, 2))
    assert back @ phi == pytest.approx(np.eye(2), abs=1e-6 * max(w, 1.0))
