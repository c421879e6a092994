"""The joint as it was measured, where the drive's model does not foretell it, or the encoder is finer than that is.

The arm is judged by how it answers the motion that its joint made, and the drive by whether the joint made the motion
that was commanded: so a drive that departs from its model leaves no trace in what is said of the arm. The simulated
joint is corrected by the measured one below the frequency at which the encoder's noise takes over. A third-order
Butterworth filter run forward and back has the response of the optimal smoother of a motion whose jerk is white,
1 / (1 + (f / f_c)^6), f_c being where the spectrum of the departure meets that of the noise.

A drive that takes a command some milliseconds late, on a computer that is loaded, leaves the joint off by some tens of
microradians. In the joint that is less than a simulation reaches; in the image of an arm of 2 m it is a tenth of a
pixel, and the arm rings with it. Where the encoder resolves it, the image is told by where the joint was.
"""

from collections.abc import Callable
from math import isfinite, pi, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, filtfilt, welch

from stillarm.diagnosis.data.noise import LEAST, resolution
from stillarm.diagnosis.data.robust import bridged, white_noise
from stillarm.diagnosis.physics.linear_modes import acceleration_of_mode, answer_of_mode

Array = NDArray[np.float64]

_SEGMENT_S = 2.0  # a segment of the departure's spectrum: lines 0.5 Hz apart
# times the noise: a Welch spectrum of 20 segments strays from its mean by less than a half
_OUTSTANDING = 4.0
_LOWEST_HZ, _HIGHEST_HZ = 1.0, 40.0  # Hz, between which a departure is followed, if there is one
_FEWEST = 500  # known samples: a segment of the spectrum then has 125


def departure_hz(measured: Array, simulated: Array, step_s: float) -> float:
    """Up to which frequency the joint's measured position departs from the simulated one by more than the encoder's
    noise and half its step, Hz; 0 where it does not. Both: (n,) rad, NaN where unmeasured."""
    off = measured - simulated
    known = np.isfinite(off)
    if known.sum() < _FEWEST:
        return 0.0
    step = resolution(measured[known])
    if not isfinite(step):
        return 0.0
    # while the joint rests or turns slowly, the rest of a rounded position is no noise, and says nothing
    off = np.sign(off) * np.maximum(np.abs(off) - 0.5 * step, 0.0)
    filled = bridged(off)
    # of what was measured alone: across gaps the straight lines have none
    noise = max(white_noise(off[known]), step / sqrt(12.0))
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


def within_reach(measured: Array, simulated: Array) -> Array:
    """By how much the joint was elsewhere than simulated, rad, no more than a simulation is taken to be off; straight
    across what was not measured. Both: (n,) rad."""
    return np.clip(bridged(measured - simulated), -LEAST["joint_position"], LEAST["joint_position"])


def noise_at_tip(noise_rad: float, modes: Array, length_m: float, step_s: float) -> float:
    """Standard deviation of what an encoder's white noise makes of `tip_moved`, m: a resonance of gain p l / (2 z) lets
    through what lies within its noise bandwidth of pi z f, of a noise of 2 noise_rad^2 step_s per Hz; far above, a mode
    takes p l of the path back. modes as there."""
    through = [
        2.0 * step_s * pi * damping * hz * (participation / (2.0 * damping)) ** 2
        for hz, damping, participation in modes
    ]
    quick = 1.0 - sum(participation for _, _, participation in modes)
    return noise_rad * length_m * sqrt(quick**2 + sum(through))


def answer_to_path(path: Array, frequency_hz: float, damping_ratio: float, step_s: float) -> Array:
    """Deflection, m, of a mode of participation 1 when the arm's root is moved along a path, (n,) m, from rest:
    q'' + 2 z w q' + w^2 q = -path'' (bilinear)."""
    # q under a force's second derivative is q'' under the force
    return acceleration_of_mode(path[0] - path, frequency_hz, damping_ratio, step_s)


def tip_moved(off: Array, modes: Array, length_m: float, answer: Callable[[float, float], Array]) -> Array:
    """What a departure of the joint, (n,) rad, does to the tip, m: the rigid arm turns with it, and each mode answers.
    modes: (m, 3) frequency_hz, damping_ratio, participation; answer: `answer_to_path` of the tip by these two."""
    moved = length_m * off
    for hz, damping, participation in modes.tolist():
        moved = moved + participation * answer(hz, damping)
    return moved
