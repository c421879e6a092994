"""The modal response against scipy's integrator."""

from math import pi, sin

import numpy as np
from scipy.integrate import solve_ivp

from common.model import Mode
from controller.modal_response import ModalResponse


def test_matches_solve_ivp_for_a_smooth_joint_acceleration() -> None:
    """q'' + 2 zeta w q' + w^2 q = -p L theta'' over two seconds, to 0.1 % of the span."""
    mode = Mode(frequency_hz=2.6, damping_ratio=0.02, participation=1.14)
    response = ModalResponse(mode, 2.0, 0.001)

    def acceleration(t: float) -> float:
        return 0.3 * sin(2 * pi * 2.2 * t) + 0.1 * sin(2 * pi * 9.0 * t)

    def slope(t: float, x: np.ndarray) -> list[float]:
        w = 2 * pi * 2.6
        return [x[1], -2 * 0.02 * w * x[1] - w * w * x[0] - 1.14 * 2.0 * acceleration(t)]

    times = np.arange(1, 2001) * 0.001
    exact = solve_ivp(slope, (0.0, 2.0), [0.0, 0.0], t_eval=times, rtol=1e-9, atol=1e-12).y
    got = []
    for t in times:
        response.advance(acceleration(t))
        got.append((response.deflection_m, response.rate_m_s))
    error = np.array(got) - exact.T
    assert np.max(np.abs(error[:, 0])) < 1e-3 * np.ptp(exact[0])
    assert np.max(np.abs(error[:, 1])) < 1e-3 * np.ptp(exact[1])
