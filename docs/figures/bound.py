"""The least possible error of one constant delay against the time that is looked at, and the methods' errors."""

from pathlib import Path

import numpy as np
from style import BLUE, GREEN, ORANGE, TRUTH, new_figure, save

ACCELEROMETER_HZ, CAMERA_HZ, FREQUENCY_HZ = 1000.0, 65.0, 2.6
VISION_NOISE = 0.01  # of the amplitude


def least_std_s(window_s: np.ndarray, noise: float) -> np.ndarray:
    """Cramer-Rao for one delay: var >= (1/w^2) (2 s_a^2 / N_a + 2 s_v^2 / N_v), noise relative to the amplitude."""
    w = 2.0 * np.pi * FREQUENCY_HZ
    per_window = 2.0 * noise**2 / (ACCELEROMETER_HZ * window_s) + 2.0 * VISION_NOISE**2 / (
        CAMERA_HZ * window_s
    )
    return np.sqrt(per_window) / w


def draw(path: Path) -> None:
    """docs/images/bound.svg"""
    window_s = np.geomspace(0.1, 10.0, 200)
    figure, (axes,) = new_figure()
    for noise, colour in ((0.1, GREEN), (0.3, BLUE), (1.0, ORANGE)):
        label = f"accelerometer noise {noise:g} of the amplitude"
        axes.loglog(window_s, 1e3 * least_std_s(window_s, noise), color=colour, label=label)
    axes.axhline(1e3 / CAMERA_HZ / np.sqrt(12.0), color=TRUTH, linestyle="--")
    axes.annotate("what a whole frame leaves open", (9.8, 4.7), ha="right", color=TRUTH)
    axes.set(xlabel="window, s", ylabel="least deviation of the delay, ms")
    axes.legend(loc="lower left")
    save(figure, path)
