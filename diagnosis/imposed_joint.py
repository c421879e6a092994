"""Where no command was recorded: the one that would have made the joint move as it was measured.

The simulated drive is a lag after a dead time, bandwidth_hz and dead_time_s of the model, so that
command(t) = omega(t + dead) + omega'(t + dead) / (2 pi bandwidth). omega and omega' are those of local cubics
(Savitzky and Golay, Analytical Chemistry 36, 1964).
"""

from math import pi

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from stillarm.common.files.model import Drive
from stillarm.diagnosis.robust import bridged, std_about_zero

Array = NDArray[np.float64]

WINDOW_S = 0.06  # passes what a joint does up to some 15 Hz
MIN_TRAVEL = 50.0  # deviations of the sensor's noise: less is no motion, but the sensor


def imposed_command(position: Array, velocity: Array, drive: Drive, cycle_s: float) -> Array | None:
    """The command, rad/s, (n,), from the joint's velocity in rad/s or else its position in rad, (n,), NaN where
    unmeasured; None where neither was measured, or the joint stood still."""
    window = max(5, 2 * round(0.5 * WINDOW_S / cycle_s) + 1)
    by_velocity = np.isfinite(velocity).sum() >= np.isfinite(position).sum()
    measured = velocity if by_velocity else position
    known = np.flatnonzero(np.isfinite(measured))
    if len(known) <= window:
        return None
    values = measured[known]
    noise = std_about_zero(np.diff(values)) / 2.0**0.5
    filled = bridged(measured)
    level = savgol_filter(filled, window, 3)
    if float(np.ptp(level)) <= MIN_TRAVEL * noise:
        return None
    rate: Array = savgol_filter(filled, window, 3, deriv=1, delta=cycle_s)
    omega: Array = level if by_velocity else rate
    change: Array = rate if by_velocity else savgol_filter(filled, window, 3, deriv=2, delta=cycle_s)
    time = np.arange(len(measured)) * cycle_s
    due: Array = np.interp(time + drive.dead_time_s, time, omega + change / (2.0 * pi * drive.bandwidth_hz))
    return due
