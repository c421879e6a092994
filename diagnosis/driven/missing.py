"""The force that a fit lacks, as a curve over the joint's angle and over its velocity, whatever its form.

Each block's residual is what a missing acceleration f(theta, theta') would have made of it through the linear model.
Here it is read in the inverse direction (Janot, Gautier, Brunot, Control Engineering Practice 2019): the joint's
measured acceleration, band-limited by a local cubic, less what the model gives for the same state and input.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from stillarm.diagnosis.driven.fitting import DrivenFit
from stillarm.diagnosis.driven.laws import pull_of
from stillarm.diagnosis.driven.regression import joint_motion

Array = NDArray[np.float64]

_WINDOW_S = 0.06  # of a local cubic: it halves an acceleration's power at 11 Hz
_BINS = 24  # over the middle 99 % of angles or velocities
_FEWEST = 12  # samples of a bin


@dataclass(frozen=True)
class Curve:
    """A missing acceleration of the joint over `at`: mean and its standard error, of bins that hold enough, rad/s^2."""

    at: Array
    mean: Array
    error: Array


@dataclass(frozen=True)
class MissingForce:
    """theta, omega, force: (n,); the curves over each."""

    theta: Array
    omega: Array
    force: Array
    over_angle: Curve
    over_velocity: Curve


def missing_force(fitted: DrivenFit) -> MissingForce | None:
    """What the linear part of a fit lacks, and all that causes have added to it; None without a sensor at the joint."""
    driven = fitted.box.driven
    motion = joint_motion(driven, _WINDOW_S)
    if motion is None:
        return None
    theta, omega, alpha = motion
    numbers, h = fitted.numbers, driven.step_s
    width = max(7, 2 * int(0.5 * _WINDOW_S / h) + 1)
    given = (
        numbers["gain"] * fitted.run.drive
        - numbers["damping"] * omega
        - numbers.get("stiffness", 0.0) * theta
    )
    for i in range(1, fitted.box.modes + 1):
        w, zeta = np.exp(numbers[f"log_w_{i}"]), numbers[f"zeta_{i}"]
        q, v = fitted.run.states[:, 2 * i], fitted.run.states[:, 2 * i + 1]
        given = given + pull_of(numbers, i) * (w * w * q + 2.0 * zeta * w * v)
    force = alpha - savgol_filter(given, width, 3)
    inner = slice(width, len(force) - width)
    theta, omega, force = theta[inner], omega[inner], force[inner]
    return MissingForce(theta, omega, force, _curve(theta, force), _curve(omega, force))


def _curve(at: Array, force: Array) -> Curve:
    low, high = np.quantile(at, [0.005, 0.995])
    edges = np.linspace(low, high, _BINS + 1)
    place = np.searchsorted(edges, at) - 1
    rows = []
    for k in range(_BINS):
        inside = force[place == k]
        if len(inside) >= _FEWEST:
            # neighbours tell the same: a tenth of the samples is taken for independent
            rows.append(
                (0.5 * (edges[k] + edges[k + 1]), inside.mean(), inside.std() / np.sqrt(len(inside) / 10.0))
            )
    return Curve(*np.array(rows).reshape(-1, 3).T)
