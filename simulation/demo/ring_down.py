"""The arm's damping from a true deflection: envelope, settling time, damping ratio."""

from math import log, pi

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]

SETTLED = 0.05  # of the struck amplitude


def envelope_m(deflection_m: Values, step_s: float, frequency_hz: float) -> Values:
    """Amplitude of an oscillation near a frequency: sqrt(q^2 + (q' / w)^2), averaged over half a period.

    The average takes out the ripple at twice the frequency that an offset or a frequency slightly off leaves.
    """
    rate = np.gradient(deflection_m, step_s)
    raw = np.hypot(deflection_m, rate / (2.0 * pi * frequency_hz))
    width = max(1, round(0.5 / frequency_hz / step_s))
    padded = np.concatenate((np.full(width // 2, raw[0]), raw, np.full(width - 1 - width // 2, raw[-1])))
    return np.convolve(padded, np.full(width, 1.0 / width), mode="valid")


def settling_time_s(envelope: Values, step_s: float, amplitude_m: float) -> float | None:
    """Time after which the envelope stays below SETTLED of the amplitude; None when it does not by the end."""
    above = np.flatnonzero(envelope >= SETTLED * amplitude_m)
    if len(above) == 0:
        return 0.0
    return None if above[-1] >= len(envelope) - 1 else float(above[-1] + 1) * step_s


def decay_rate_per_s(envelope: Values, step_s: float, amplitude_m: float, down_to: float) -> float | None:
    """Rate of an exponential fitted to the envelope from its start down to a fraction of the amplitude.

    Least squares on the logarithm. None when fewer than ten samples lie above the fraction.
    """
    below = np.flatnonzero(envelope < down_to * amplitude_m)
    end = int(below[0]) if len(below) else len(envelope)
    if end < 10:
        return None
    slope, _ = np.polyfit(np.arange(end) * step_s, np.log(envelope[:end]), 1)
    return float(-slope)


def fitted_settling_time_s(decay_per_s: float) -> float | None:
    """When an exponential of that rate reaches SETTLED; None when it does not decay."""
    return log(1.0 / SETTLED) / decay_per_s if decay_per_s > 0.0 else None
