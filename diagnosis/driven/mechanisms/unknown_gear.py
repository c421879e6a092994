"""Gravity where nobody knows how far the joint turns: behind a motor's encoder with an unstated gear, in counts, or by
a velocity in volts.

Gravity has one period a turn of the joint, and so fewer a turn of the motor. It is a wave over the measured angle whose
cycles are a number more, in the place of a ripple's in the equations: beside one, no ripple is sought.
"""

from collections.abc import Iterator

import numpy as np

from stillarm.diagnosis.driven.fitting.fitting import DrivenFit
from stillarm.diagnosis.driven.fitting.freedom import STATED
from stillarm.diagnosis.driven.recording.regression import JOINT, joint_motion

_PERIODS = (0.15, 0.5)  # over the travel: where fits begin; of more than one it is a ripple (waves.py)
_HUNDREDTH = 0.01  # of the usual force: as good as none, and clear of rounding


def gear_is_unknown(fitted: DrivenFit) -> bool:
    """Whether the measured angle's turns are no known ones of the joint, and no other wave is in the model."""
    joint = next((one for kind in JOINT for one in fitted.box.driven.outputs if one.kind == kind), None)
    if joint is None or STATED in fitted.numbers:
        return False
    others = {"ripple_cycles", "gravity_sine"} & {*fitted.free, *fitted.box.declared}
    return (joint.kind == "motor" or not joint.stated) and not others


def has_geared_gravity(fitted: DrivenFit) -> bool:
    """Whether such gravity is in the model already."""
    return "gravity_cycles" in {*fitted.free, *fitted.box.declared}


def gravity_behind_a_gear(fitted: DrivenFit) -> Iterator[dict[str, float]]:
    """Starts: sine and cosine each by itself, of a few periods over the travel."""
    motion = joint_motion(fitted.box.driven, numbers=fitted.numbers)
    travel = 0.0 if motion is None else float(np.ptp(motion[0]))
    small = _HUNDREDTH * float(abs(fitted.numbers["gain"]) * np.std(fitted.run.drive))
    for periods in _PERIODS if travel > 0.0 else ():
        cycles = periods * 2.0 * np.pi / travel
        yield {"gravity_cycles": cycles, "gravity_sine": small, "gravity_cosine": 0.0}
        yield {"gravity_cycles": cycles, "gravity_sine": 0.0, "gravity_cosine": small}
