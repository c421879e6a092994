"""A wave whose size and phase take a course of their own over time.

    c(t) cos(2 pi f t) + s(t) sin(2 pi f t)

c and s are cubic splines (de Boor, A Practical Guide to Splines, 1978), which also take up by how much f is off.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

Array = NDArray[np.float64]

_KNOTS_S = 2.0  # a cubic spline then follows a swell of 7 s to 1 %
_MOST_PIECES = 24  # each is two columns of the recording's length: 40 MB at 50 000 cycles in all


def wave_columns(time_s: Array, duration_s: float, hz: float) -> Array:
    """The terms of a wave of size 1: those of the cosine, and as many of the sine, (samples, amounts)."""
    course = _splines(time_s, duration_s, min(int(duration_s / _KNOTS_S) + 1, _MOST_PIECES))
    phase = 2.0 * np.pi * hz * time_s[:, None]
    return np.concatenate([course * np.cos(phase), course * np.sin(phase)], axis=1)


def phasor_of(amounts: Array, time_s: Array, duration_s: float) -> NDArray[np.complex128]:
    """c - i s of a wave of these amounts, complex, (samples,): of this size, and ahead of cos(2 pi f t) by its
    angle."""
    half = len(amounts) // 2
    course = _splines(time_s, duration_s, half - 3)
    return np.asarray(course @ amounts[:half] - 1j * (course @ amounts[half:]))


def _splines(time_s: Array, duration_s: float, pieces: int) -> Array:
    """Cubic B-splines over the recording, (samples, pieces + 3)."""
    inner = np.linspace(0.0, duration_s, pieces + 1)
    knots = np.concatenate([np.zeros(3), inner, np.full(3, duration_s)])
    within = np.clip(time_s, 0.0, duration_s)
    return np.asarray(BSpline.design_matrix(within, knots, 3).toarray())
