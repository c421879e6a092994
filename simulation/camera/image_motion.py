"""How a pose of the tip moves the image, and how an exposure is cut into sub-exposures."""

from collections.abc import Callable
from functools import lru_cache
from math import ceil

import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.model import Camera
from stillarm.simulation.camera.image_effects import ImageEffects

FloatArray = NDArray[np.float64]
Interpolate = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""Positions (m) and angles (rad) of the tip at given times (s), as PoseHistory.interpolate gives them."""

_FEWEST, _MOST = 3, 64


def displacement_px(camera: Camera, positions_m: FloatArray, angles_rad: FloatArray) -> FloatArray:
    """Image motion of the scene: - scale_px_per_m * s - rotation_px_per_rad * (theta + slope of the tip)."""
    return -camera.scale_px_per_m * positions_m - camera.rotation_px_per_rad * angles_rad


def mean_displacement_px(
    camera: Camera, interpolate: Interpolate, exposure_start_s: float, effects: ImageEffects | None = None
) -> float:
    """Displacement averaged over the exposure (of the middle row, with a rolling shutter)."""
    fractions, weights = quadrature(_FEWEST)
    start = exposure_start_s + (0.5 * camera.readout_s if camera.shutter == "rolling" else 0.0)
    times = start + camera.exposure_s * fractions
    positions, angles = interpolate(times)
    if effects is not None:
        return float(weights @ effects.shown_px(displacement_px(camera, positions, angles), times))
    position, angle = weights @ positions, weights @ angles
    return float(-camera.scale_px_per_m * position - camera.rotation_px_per_rad * angle)


def sub_exposures(span_px: float) -> int:
    """Number of sub-exposures for an image that moves by `span_px` during its exposure.

    Gauss's rule with n nodes integrates a wave of c radians to either side of the middle once n > c; the
    scene's finest wave (stillarm.simulation.camera.scene.CUTOFF) has c = pi * 0.25 * span_px.
    """
    return min(_MOST, max(_FEWEST, 2 + ceil(span_px)))


@lru_cache(maxsize=_MOST)
def quadrature(nodes: int) -> tuple[FloatArray, FloatArray]:
    """Gauss-Legendre nodes as fractions of the exposure, in (0, 1), and weights that add up to 1."""
    places, weights = np.polynomial.legendre.leggauss(nodes)
    return 0.5 * (places + 1.0), 0.5 * weights
