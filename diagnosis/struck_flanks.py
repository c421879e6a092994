"""What an accelerometer shows as a gear's flanks strike: a shake of some milliseconds, as stiff as the teeth are.

No step of a cycle says when in it they meet, nor how they give way. Such a sample tells that they struck, which every
play foretells, and little more: a residual there is no longer than noise often is, as far as a strike can reach.
"""

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.robust import white_noise

Array = NDArray[np.float64]

_AS_NOISE = 3.0  # deviations
_SHAKES_S = 0.01


def fast_noise(acceleration: Array) -> float:
    """Deviation of an accelerometer's white noise, m/s^2, by fifth differences, in which no motion of the arm shows.
    acceleration: (n,), NaN where unmeasured."""
    return white_noise(acceleration, 5)


def without_strikes(residual: Array, omega: Array, length_m: float, noise: float, step_s: float) -> Array:
    """An accelerometer's residual, m/s^2, (n,), less what strikes may have added to it.

    omega: (n,) velocity of the joint behind the gear, rad/s: it rests between the flanks, and jumps as they meet.
    length_m: of the arm, of which no more shakes than all of it as one.
    """
    struck = np.flatnonzero((omega[1:] != 0.0) != (omega[:-1] != 0.0)) + 1
    reach = np.zeros(len(omega))
    jump = np.abs(length_m * (omega[struck] - omega[struck - 1])) / step_s
    for later in range(-1, round(_SHAKES_S / step_s)):
        at = np.clip(struck + later, 0, len(omega) - 1)
        np.maximum.at(reach, at, jump)
    most = _AS_NOISE * noise
    long = np.clip(np.abs(residual) - most, 0.0, reach)
    return np.asarray(residual - np.sign(residual) * long)
