"""What an estimator could reach that knew all but the motion: rig, noise, dates of the images, moments of each event.

From a swing's beginning on it fits two numbers, cosine and sine of a decaying vibration, to all that has been read. Its
covariance is the inverse of the information; a Gaussian error's mean size is sqrt(2 / pi) of its deviation.
It forgets what it knew before the swing. So it is no bound, but what a figure in per cent has to be compared with:
five times the image's noise for two seconds cannot give half a per cent, whoever computes it.
"""

import numpy as np
from numpy.typing import NDArray

from tests.hidden_world.swings.rig import TICK_S, Case
from tests.hidden_world.swings.sensors import Recording

Values = NDArray[np.float64]
_SCORED_FROM_S, _VISIBLE = 0.5, 0.3


def informed_error(recording: Recording) -> float:
    """Mean expected |error| over the local amplitude, over the spans that are scored; 1 at most at any time."""
    parts = [_of_swing(recording, begin, end) for begin, end in recording.swings_s]
    parts = [part for part in parts if len(part)]
    return float(np.mean(np.concatenate(parts))) if parts else 1.0


def _of_swing(recording: Recording, begin_s: float, end_s: float) -> Values:
    case, motion = recording.case, recording.motion
    w, z = 2.0 * np.pi * case.modes[0].frequency_hz, case.modes[0].damping_ratio
    t = np.arange(begin_s, end_s, TICK_S)
    information = np.zeros((3, len(t)))
    if case.accelerometer.state == "good":
        information += _information(t - begin_s, w, z) / _accelerometer_variance(case, w)
    seen = recording.images
    use = (seen.middle_s > begin_s) & (seen.received_s < end_s)
    read = np.clip(((seen.received_s[use] - begin_s) / TICK_S).astype(int), 0, len(t) - 1)
    told = _information(seen.middle_s[use] - begin_s, w, z) / _image_variance(case)
    for row, each in zip(information, told, strict=True):
        np.add.at(row, read, each)
    cc, cs, ss = np.cumsum(information, axis=1)
    determinant = cc * ss - cs * cs
    here = _information(t - begin_s, w, z)
    with np.errstate(divide="ignore", invalid="ignore"):
        variance = (here[0] * ss - 2.0 * here[1] * cs + here[2] * cc) / determinant
    std = np.sqrt(np.where(determinant > 1e-9 * cc * ss, np.abs(variance), np.inf))
    inside = (motion.time_s >= begin_s) & (motion.time_s < end_s)
    amplitude = _amplitude(motion.time_s[inside], motion.deflection_m[inside], np.pi / w, t)
    scored = (amplitude > _VISIBLE * amplitude.max()) & (t >= begin_s + _SCORED_FROM_S)
    return np.asarray(np.minimum(1.0, np.sqrt(2.0 / np.pi) * std / amplitude)[scored])


def _information(since_s: Values, w: float, z: float) -> Values:
    """Products of the two shapes at these times: cos cos, cos sin, sin sin. Shape (3, times)."""
    decay = np.exp(-2.0 * z * w * since_s)
    c, s = np.cos(w * since_s), np.sin(w * since_s)
    return np.array([decay * c * c, decay * c * s, decay * s * s])


def _image_variance(case: Case) -> float:
    """Of noise as it averages out over many images, m^2."""
    rho = case.camera.colour
    return case.noise_m**2 * (1.0 + rho) / (1.0 - rho)


def _accelerometer_variance(case: Case, w: float) -> float:
    """The same of one sample, as a deflection, m^2."""
    feeler = case.accelerometer
    rho = feeler.colour
    return (feeler.noise_m_s2 / (w * w)) ** 2 * (1.0 + rho) / (1.0 - rho)


def _amplitude(time_s: Values, q: Values, half_s: float, at_s: Values) -> Values:
    """Largest |q| within half_s either side."""
    even = np.arange(time_s[0], time_s[-1], 2.0 * TICK_S)
    size = np.abs(np.interp(even, time_s, q))
    half = max(1, round(half_s / (2.0 * TICK_S)))
    padded = np.pad(size, half, mode="edge")
    largest = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1).max(axis=1)
    return np.asarray(np.maximum(np.interp(at_s, even, largest), 1e-12))
