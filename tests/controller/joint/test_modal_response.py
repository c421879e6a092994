"""The modal response against scipy's integrator."""

from math import pi, sin

import numpy as np
from scipy.integrate import solve_ivp

from stillarm.common.files.model import Drive, Mode
from stillarm.controller.joint.drive_model import DriveModel
from stillarm.controller.joint.modal_response import ModalResponse


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
        response.advance(acceleration(t - 0.0005))  # the mean over the cycle, to second order
        got.append((response.deflection_m, response.rate_m_s))
    error = np.array(got) - exact.T
    assert np.max(np.abs(error[:, 0])) < 1e-3 * np.ptp(exact[0])
    assert np.max(np.abs(error[:, 1])) < 1e-3 * np.ptp(exact[1])


def test_in_series_with_the_drive_model_it_follows_a_finer_integration() -> None:
    """Commands held over each cycle, as they are sent: theta'' is a sawtooth, and its mean is what bends the arm."""
    mode = Mode(frequency_hz=2.6, damping_ratio=0.02, participation=1.14)
    drive, response = DriveModel(Drive(dead_time_s=0.0), 0.001), ModalResponse(mode, 2.0, 0.001)
    commands = [0.02 * sin(2 * pi * 2.6 * k * 0.001) for k in range(1500)]
    rate, w = 2 * pi * 20.0, 2 * pi * 2.6
    fine, h = 20, 0.001 / 20
    velocity = q = v = 0.0
    found, exact = [], []
    for command in commands:
        for _ in range(fine):  # semi-implicit Euler
            acceleration = rate * (command - velocity)
            velocity += h * acceleration
            v += h * (-2 * 0.02 * w * v - w * w * q - 1.14 * 2.0 * acceleration)
            q += h * v
        drive.advance(command)
        response.advance(drive.mean_acceleration_rad_s2)
        found.append(response.deflection_m)
        exact.append(q)
    assert np.max(np.abs(np.array(found) - exact)) < 0.01 * np.ptp(exact)
