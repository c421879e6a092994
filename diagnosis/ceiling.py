"""An accelerometer at its limit: samples that pile up at one size, on both sides."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.measured import Measured

Array = NDArray[np.float64]

_CLOSE = 0.9


def ceiling_of(acceleration: Array, noise: float) -> float | None:
    """The size at which they pile up, m/s^2, if more lie about it than anywhere above a fifth of it. noise: m/s^2."""
    values = np.abs(acceleration[np.isfinite(acceleration)])
    counts, edges = np.histogram(values, bins=40)
    top = int(np.argmax(counts[8:])) + 8
    if counts[top] < 0.05 * len(values) or counts[top] < 1.5 * counts[top // 2]:
        return None
    level = float(0.5 * (edges[top] + edges[top + 1]))
    return level if level > 2.0 * noise else None


def below(measured: Measured, ceiling: float) -> Measured:
    """The recording without the samples that lie near the limit: what they say of the motion is wrong."""
    kept = np.where(np.abs(measured.acceleration) < _CLOSE * ceiling, measured.acceleration, np.nan)
    return replace(measured, acceleration=kept)
