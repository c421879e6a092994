"""The joint as it was measured, where the drive's model does not foretell it.

The arm is judged by how it answers the motion that its joint made, and the drive by whether the joint made the motion
that was commanded: so a drive that departs from its model leaves no trace in what is said of the arm. The simulated
joint is corrected by the measured one below the frequency at which the encoder's noise takes over. A third-order
Butterworth filter run forward and back has the response of the optimal smoother of a motion whose jerk is white,
1 / (1 + (f / f_c)^6), f_c being where the spectrum of the departure meets that of the noise.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, filtfilt, welch

from stillarm.diagnosis.added import answer_of_mode
from stillarm.diagnosis.robust import bridged, white_noise

Array = NDArray[np.float64]

_SEGMENT_S = 2.0  # of the departure's spectrum
_OUTSTANDING = (
    4.0  # times the noise: a Welch spectrum of 20 segments strays from its mean by less than a half
)
_LOWEST_HZ, _HIGHEST_HZ = 1.0, 40.0
_FEWEST = 500


def departure_hz(measured: Array, simulated: Array, step_s: float) -> float:
    """Up to which frequency the joint's measured position departs from the simulated one by more than the encoder's
    noise, Hz; 0 where it does not. Both: (n,) rad, NaN where unmeasured."""
    off = measured - simulated
    known = np.isfinite(off)
    if known.sum() < _FEWEST:
        return 0.0
    filled = bridged(off)
    # of what was measured alone: across gaps the straight lines have none
    noise = white_noise(off[known])
    length = min(int(_SEGMENT_S / step_s), len(filled) // 4)
    hz, power = welch(filled, 1.0 / step_s, nperseg=length, detrend="constant")
    floor = max(noise**2, 1e-16) * 2.0 * step_s * len(off) / known.sum()
    above = np.flatnonzero((power > _OUTSTANDING * floor) & (hz > 0.0))
    if not len(above):
        return 0.0
    first_below = np.flatnonzero((power <= _OUTSTANDING * floor) & (hz > hz[above[0]]))
    top = float(hz[first_below[0]]) if len(first_below) else _HIGHEST_HZ
    return min(max(top, _LOWEST_HZ), _HIGHEST_HZ, 0.2 / step_s)


def smoothed(off: Array, hz: float, step_s: float) -> tuple[Array, Array]:
    """The departure below a frequency, rad, and its second derivative, rad/s^2. off: (n,) rad, NaN where unmeasured."""
    b, a = butter(3, 2.0 * hz * step_s)
    slow = filtfilt(b, a, bridged(off), padlen=min(3 * max(len(a), len(b)) * 20, len(off) - 2))
    second = np.zeros(len(slow))
    second[1:-1] = (slow[2:] - 2.0 * slow[1:-1] + slow[:-2]) / step_s**2
    return np.asarray(slow), second


def answer_to_joint(
    acceleration: Array, frequency_hz: float, damping_ratio: float, push: float, step_s: float
) -> tuple[Array, Array]:
    """How a mode answers a further acceleration of the joint, (n,) rad/s^2: its deflection, m, and that one's second
    derivative. push: participation times length, m. q'' + 2 z w q' + w^2 q = -push a (bilinear)."""
    return answer_of_mode(-push * acceleration, frequency_hz, damping_ratio, step_s)
