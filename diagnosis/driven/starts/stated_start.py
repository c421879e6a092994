"""The start where a model file states joint and arm: its numbers, refitted in what may be off without being a cause."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.driven.fitting.fitting import DrivenFit, fit
from stillarm.diagnosis.driven.fitting.freedom import STATED, free_of, has_joint
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.greybox.input_path import STEADY
from stillarm.diagnosis.driven.recording.regression import JOINT, joint_numbers, numbers_without_joint
from stillarm.diagnosis.driven.starts.stated import Stated

Array = NDArray[np.float64]


def stated_start(plain: GreyBox, stated: Stated) -> DrivenFit:
    """The stated joint, refitted in what may be off without being a cause."""
    driven = plain.driven
    box = replace(plain, modes=stated.modes)
    begun = joint_numbers(driven) if has_joint(driven) else numbers_without_joint(driven)
    first = next((kind for kind in JOINT if any(one.kind == kind for one in driven.outputs)), "")
    if first == "motor":  # the regression is of the motor's angle, the model of the joint's
        turns = next(stated.numbers[f"scale {one.name}"] for one in driven.outputs if one.kind == "motor")
        begun["gain"] /= turns
    numbers = {**begun, **stated.numbers, STATED: 1.0, **plain.declared}
    for one in driven.outputs:
        numbers.setdefault(f"offset {one.name}", 0.0)
        if one.kind == "acceleration":
            for i in range(1, stated.modes + 1):
                numbers.setdefault(f"share_{i} {one.name}", 1.0)
    free = [one for one in free_of(box) if one not in stated.fixed]
    if not any(
        one.kind == "deflection" for one in driven.outputs
    ):  # an accelerometer sees the tip in its own size
        free += [f"follows_{i}" for i in range(1, stated.modes + 1) if f"stated_follows_{i}" in numbers]
    if "gain" in stated.fixed:  # nothing else takes up the scale of a sensor whose unit nobody knows
        free += [f"scale {one.name}" for one in driven.outputs if one.kind in JOINT and not one.stated]
    if numbers["lag"] > 0.0:
        numbers[STEADY] = 1.0
        free.append(STEADY)
    begun = _with_sensors_scaled(box, numbers, free)
    return fit(replace(box, begun=begun), begun, tuple(dict.fromkeys(free)))


def _with_sensors_scaled(box: GreyBox, numbers: dict[str, float], free: list[str]) -> dict[str, float]:
    """The numbers with a scale for each sensor whose unit nobody knows: what the stated joint and arm, from rest, make
    of the input, against what was measured."""
    unknown = [one for one in box.driven.outputs if not one.stated]
    bent = [one for one in unknown if one.kind == "deflection" and box.modes]
    turned = [one for one in unknown if f"scale {one.name}" in free]
    if not bent and not turned:
        return numbers
    simulated = box.run(numbers, np.zeros((len(box.split.held), box.size))).outputs
    scaled = dict(numbers)
    for one in bent[:1]:
        scale = _scale_between(simulated[one.name], one.values)
        follows = [f"follows_{i}" for i in range(1, box.modes + 1)]
        scaled |= {name: scale * numbers[name] for name in follows}
    for one in turned:  # by their rates: an angle drifts
        scale = _scale_between(np.gradient(simulated[one.name]), np.gradient(one.values))
        scaled[f"scale {one.name}"] = scale * numbers.get(f"scale {one.name}", 1.0)
    return scaled


def _scale_between(simulated: Array, measured: Array) -> float:
    """What the simulated values are multiplied by to be the measured ones; 1 where nothing tells."""
    known = np.isfinite(measured)
    columns = np.column_stack([simulated[known], np.ones(known.sum())])
    return float(np.linalg.lstsq(columns, measured[known], rcond=None)[0][0]) or 1.0
