"""The joint's numbers from its measured motion: acceleration by local cubics, regressed on input and velocity."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter, savgol_filter

from stillarm.diagnosis.driven.recording.own import numbers_in
from stillarm.diagnosis.driven.recording.signals import Driven, Output

Array = NDArray[np.float64]

JOINT = ("position", "motor", "velocity")
"""Kinds of sensors that look at the joint, the best first."""
_WINDOW_S = 0.05  # of a local cubic: it halves an acceleration's power at 13 Hz
_AS_MEASURED: Mapping[str, float] = MappingProxyType({})


def scale_is_open(output: Output, position: Output) -> bool:
    """Whether nobody knows an output's scale against the angle: no unit, or a motor's angle before an unknown gear."""
    return not output.stated or "motor" in {output.kind, position.kind}


def resonance(u: Array, w: float, zeta: float, step_s: float) -> Array:
    """q of q'' + 2 zeta w q' + w^2 q = u, held between samples, from rest."""
    damped, keep = w * np.sqrt(1.0 - zeta * zeta), np.exp(-zeta * w * step_s)
    cosine, sine = keep * np.cos(damped * step_s), keep * np.sin(damped * step_s)
    tilt = zeta * w / damped
    one = (1.0 - cosine - tilt * sine) / (w * w)
    two = (keep * keep + tilt * sine - cosine) / (w * w)
    return np.asarray(lfilter([0.0, one, two], [1.0, -2.0 * cosine, keep * keep], u))


def joint_motion(
    driven: Driven, window_s: float = _WINDOW_S, numbers: Mapping[str, float] = _AS_MEASURED
) -> tuple[Array, Array, Array] | None:
    """theta, theta', theta'' of the joint as measured, by local cubics; None where no sensor looks at it. numbers: of a
    fit, in whose units the motion then is: a motor turns by a stated gear's ratio more than the joint."""
    if driven.joins:
        each = [
            joint_motion(driven.part(k), window_s, numbers_in(numbers, k)) for k in range(driven.recordings)
        ]
        there = [one for one in each if one is not None]
        return (
            None
            if len(there) < len(each)
            else (
                np.concatenate([one[0] for one in there]),
                np.concatenate([one[1] for one in there]),
                np.concatenate([one[2] for one in there]),
            )
        )
    sensor = next((one for kind in JOINT for one in driven.outputs if one.kind == kind), None)
    if sensor is None:
        return None
    h = driven.step_s
    known = np.isfinite(sensor.values)
    values = np.interp(np.arange(driven.samples), np.flatnonzero(known), sensor.values[known])
    values /= numbers.get(f"scale {sensor.name}", 1.0) or 1.0
    width = max(7, 2 * int(0.5 * window_s / h) + 1)
    order = [savgol_filter(values, width, 3, deriv=d, delta=h) for d in range(3)]
    if sensor.kind == "velocity":
        return np.concatenate([[0.0], np.cumsum(order[0][1:] + order[0][:-1]) * 0.5 * h]), order[0], order[1]
    return order[0], order[1], order[2]


def regressed_joint(
    driven: Driven, arm: Array | None = None, numbers: Mapping[str, float] = _AS_MEASURED
) -> tuple[float, float, float, float] | None:
    """Gain, damping, dry friction of the joint and half its difference by direction, from its measured acceleration;
    None without a sensor there.

    arm: (n,) what the modes do to the joint, rad/s^2. numbers: of a fit, see `joint_motion`.
    """
    motion = joint_motion(driven, numbers=numbers)
    if motion is None:
        return None
    _, omega, alpha = motion
    width = width_of(driven.step_s)
    u = savgol_filter(driven.u, width, 3)
    small = 0.02 * np.max(np.abs(omega))
    columns = np.column_stack([u, -omega, np.ones_like(u), -np.tanh(omega / max(small, 1e-12))])
    size = np.maximum(np.std(columns, axis=0), 1e-12)
    size[2] = 1.0
    wanted = alpha if arm is None else alpha - arm
    factor = np.linalg.lstsq(columns / size, wanted, rcond=1e-4)[0] / size
    return float(factor[0]), max(float(factor[1]), 0.0), float(factor[3]), -float(factor[2])


def joint_numbers(driven: Driven) -> dict[str, float]:
    """Start values of the joint and of its sensors."""
    motion, found = joint_motion(driven), regressed_joint(driven)
    assert motion is not None and found is not None
    _, omega, alpha = motion
    numbers = {"gain": found[0], "damping": found[1], "delay": 0.0}
    for one in driven.outputs:
        numbers[f"offset {one.name}"] = 0.0
        numbers[f"scale {one.name}"] = 1.0
        if one.kind == "acceleration":
            numbers[f"jump {one.name}"] = 1.0
            numbers[f"direct {one.name}"] = float(np.nanstd(one.values) / max(float(np.std(alpha)), 1e-12))
    _scale_second_sensors(driven, numbers, omega)
    return numbers


def numbers_without_joint(driven: Driven) -> dict[str, float]:
    """Start values where no sensor looks at the joint."""
    jumps = {f"jump {one.name}": 1.0 for one in driven.outputs if one.kind == "acceleration"}
    return {"gain": 1.0 / size_of(driven.u), "damping": 0.0, "delay": 0.0, **jumps}


def _scale_second_sensors(driven: Driven, numbers: dict[str, float], omega: Array) -> None:
    """Start values of the scales against the first angle."""
    first = next((one for kind in ("position", "motor") for one in driven.outputs if one.kind == kind), None)
    for one in driven.outputs:
        if first is None or one is first or not scale_is_open(one, first):
            continue
        if one.kind == "velocity":
            known = np.isfinite(one.values)
            size = max(float(np.dot(omega[known], omega[known])), 1e-12)
            numbers[f"scale {one.name}"] = float(np.dot(one.values[known], omega[known])) / size
        elif one.kind == "motor":
            known = np.isfinite(one.values) & np.isfinite(first.values)
            numbers[f"scale {one.name}"] = float(np.polyfit(first.values[known], one.values[known], 1)[0])


def width_of(step_s: float) -> int:
    """Samples of a local cubic, an odd number."""
    return max(7, 2 * int(0.5 * _WINDOW_S / step_s) + 1)


def size_of(values: Array) -> float:
    """Deviation of values, never zero."""
    return max(float(np.std(values)), 1e-12)
