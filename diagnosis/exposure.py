"""What an exposure shows of a scene that moves: its mean place, and how fast it passes. Compiled."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

_SLOPE_S = 0.002  # the rate is taken over twice this


@njit(cache=True, nogil=True, error_model="numpy")
def _place(scene: Array, x: float) -> float:
    """The scene at x samples, linear between them, held beyond its ends; NaN for NaN."""
    if np.isnan(x):
        return np.nan
    x = min(max(x, 0.0), scene.shape[0] - 1.0)
    k = min(int(x), scene.shape[0] - 2)
    place: float = scene[k] + (x - k) * (scene[k + 1] - scene[k])
    return place


@njit(cache=True, nogil=True, error_model="numpy")
def _mean(scene: Array, start: float, end: float) -> float:
    """Mean of the piecewise linear scene between two places, in samples, within it."""
    first, last = int(np.ceil(start)), int(np.floor(end))
    if last < first:
        return 0.5 * (_place(scene, start) + _place(scene, end))
    total = 0.5 * (first - start) * (_place(scene, start) + scene[first])
    for k in range(first, last):
        total += 0.5 * (scene[k] + scene[k + 1])
    total += 0.5 * (end - last) * (scene[last] + _place(scene, end))
    mean: float = total / (end - start)
    return mean


@njit(cache=True, nogil=True, error_model="numpy")
def expose(
    scene: Array, instants_s: Array, exposure_s: float, cycle_s: float, out_value: Array, out_rate: Array
) -> None:
    """Mean place over each exposure and its rate, 1/s, at mid-exposures `instants_s` (frames,).

    scene: (cycles,), linear between cycles. An exposure shorter than a cycle, or not wholly within the scene, shows
    the place at its middle.
    """
    last, slope = scene.shape[0] - 1.0, _SLOPE_S / cycle_s
    for i in range(instants_s.shape[0]):
        x, half = instants_s[i] / cycle_s, 0.5 * exposure_s / cycle_s
        if exposure_s >= cycle_s and x - half >= 0.0 and x + half <= last:
            out_value[i] = _mean(scene, x - half, x + half)
        else:
            out_value[i] = _place(scene, x)
        out_rate[i] = (_place(scene, x + slope) - _place(scene, x - slope)) / (2.0 * _SLOPE_S)
