"""A joint that rubs, begun anew: dry friction beside which a linear fit has settled on another joint and another arm.

Where most of the torque goes into friction, the linear start's gain, damping and first mode make up for that, and no
friction that is added to them leads back. Here a rigid joint with friction is fitted first, from several dampings, and
the arm is sought on it.
"""

from collections.abc import Iterator

import numpy as np

from stillarm.diagnosis.driven.fitting.fitting import DrivenFit, fit
from stillarm.diagnosis.driven.fitting.freedom import STATED, free_of, has_joint
from stillarm.diagnosis.driven.starts.begins import best_begins, damped_joints, on_a_damped_joint, seen_begins
from stillarm.diagnosis.driven.starts.start import modes_to_try

_SHARES = (0.15, 0.5)  # of the usual torque, which friction takes
_QUICK = 8  # steps of a fit


def anew_with_friction(fitted: DrivenFit) -> Iterator[dict[str, float]]:
    """Numbers of joint, first mode and friction, where nothing but the linear start has been fitted yet."""
    box, driven = fitted.box, fitted.box.driven
    plain = set(fitted.free) <= set(free_of(box)) and not box.play and STATED not in fitted.numbers
    if not plain or box.modes > 1 or not has_joint(driven):
        return
    rigid, size = box.without_arm(), float(np.std(driven.u))
    free = (*free_of(rigid), "coulomb")
    joints = [
        {**one, "coulomb": share * abs(one["gain"]) * size}
        for one in (fitted.numbers, *damped_joints(driven, fitted.numbers))
        for share in _SHARES
    ]
    best = best_begins(rigid, joints, free, None, 1)[0]
    joint = fit(rigid, best.numbers, free, best.states, steps=_QUICK).numbers
    if not box.modes:
        yield joint
        return
    begins = [*modes_to_try(rigid, joint, None), *seen_begins(driven, joint, 1)]
    begins = [{**on_a_damped_joint(one, joint), "coulomb": _of_hub(one, joint)} for one in begins]
    free = (*free_of(box), "coulomb")
    for one in best_begins(box, begins, free, None, 2):
        yield one.numbers


def _of_hub(begin: dict[str, float], joint: dict[str, float]) -> float:
    return joint["coulomb"] * (1.0 + begin["carries_1"])
