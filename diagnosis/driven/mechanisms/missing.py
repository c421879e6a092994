"""The force that a fit lacks, as a curve over the joint's angle and over its velocity, whatever its form.

Each block's residual is what a missing acceleration f(theta, theta') would have made of it through the linear model.
Here it is read in the inverse direction (Janot, Gautier, Brunot, Control Engineering Practice 2019): the joint's
measured acceleration, band-limited by a local cubic, less what the model gives for the same state and input.

Where no sensor looks at the joint, the force is the one on a mode of the arm: what a residual r asks for through the
mode's own transfer, over a band about its frequency,

    deflection:    F = (w^2 - W^2 + 2 i zeta w W) R
    acceleration:  F = (w^2 - W^2 + 2 i zeta w W) R / (- W^2)

over the mode's deflection and its rate, which the residual corrects alike.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.driven.fitting.fitting import DrivenFit
from stillarm.diagnosis.driven.greybox.laws import pull_of
from stillarm.diagnosis.driven.recording.regression import joint_motion

Array = NDArray[np.float64]

_WINDOW_S = 0.06  # of a local cubic: it halves an acceleration's power at 11 Hz
_BINS = 24  # over the middle 99 % of angles or velocities
_FEWEST = 12  # samples of a bin
_NEAR, _WIDE = (
    1.5,
    3.5,
)  # times a mode's frequency: where it shows, and where a force on it is told, up to its third
_ENDS = 50  # parts of a recording, of which the first and the last are left out


@dataclass(frozen=True)
class Curve:
    """A missing acceleration of the joint over `at`: mean and its standard error, of bins that hold enough, rad/s^2."""

    at: Array
    mean: Array
    error: Array


@dataclass(frozen=True)
class MissingForce:
    """theta, omega, force: (n,); the curves over each. mode: number of the arm's mode whose deflection and rate stand
    in place of the joint's angle and velocity, 0 for the joint."""

    theta: Array
    omega: Array
    force: Array
    over_angle: Curve
    over_velocity: Curve
    mode: int = 0


def missing_force(fitted: DrivenFit) -> MissingForce | None:
    """What the linear part of a fit lacks, and all that causes have added to it; None without a sensor at the joint."""
    driven = fitted.box.driven
    motion = joint_motion(driven, _WINDOW_S, fitted.numbers)
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


def missing_bend(fitted: DrivenFit) -> MissingForce | None:
    """What the linear part of a fit lacks on the mode that its residual shows most, by the first sensor of the arm;
    None without one. In the sensor's unit per s^2, or that of an acceleration; of several recordings, of the first."""
    if fitted.box.driven.joins:
        fitted = fitted.part(0)
    output = next(
        (one for one in fitted.box.driven.outputs if one.kind in ("deflection", "acceleration")), None
    )
    if output is None or not fitted.box.modes:
        return None
    # one free run over all: where a block begins anew, its state would pass for a blow
    box = replace(fitted.box, split=Split(np.array([0.0, fitted.box.driven.duration_s]), np.zeros(1, bool)))
    run = box.run(fitted.numbers, fitted.states[:1])
    residual = np.nan_to_num(output.values - run.outputs[output.name])
    spectrum = np.fft.rfft(residual - residual.mean())
    at = 2.0 * np.pi * np.fft.rfftfreq(len(residual), fitted.box.driven.step_s)
    at[0] = at[1]
    modes = range(1, fitted.box.modes + 1)
    own = {i: float(np.exp(fitted.numbers[f"log_w_{i}"])) for i in modes}
    near = {
        i: float(np.sum(np.abs(spectrum[(at > own[i] / _NEAR) & (at < own[i] * _NEAR)]) ** 2)) for i in modes
    }
    mode = max(modes, key=lambda i: near[i])
    w, zeta = own[mode], fitted.numbers[f"zeta_{mode}"]
    moves = spectrum / (
        -(at**2) if output.kind == "acceleration" else 1.0
    )  # what the mode lacks of its motion
    lowest = w / _WIDE if output.kind == "acceleration" else 0.0  # two integrals of noise drift
    moves[(at < lowest) | (at > w * _WIDE)] = 0.0
    more, faster, force = (
        np.fft.irfft(moves * through, len(residual))
        for through in (np.ones_like(at), 1j * at, w * w - at**2 + 2j * zeta * w * at)
    )
    share = fitted.numbers.get(f"share_{mode} {output.name}", 1.0) if output.kind == "acceleration" else 1.0
    q, v = share * run.states[:, 2 * mode] + more, share * run.states[:, 2 * mode + 1] + faster
    inner = slice(len(force) // _ENDS, -(len(force) // _ENDS))  # a transform's ends meet
    q, v, force = q[inner], v[inner], force[inner]
    return MissingForce(q, v, force, _curve(q, force), _curve(v, force), mode)


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
