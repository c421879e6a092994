"""The baseline of the recording's first part, where that foretells its part far better than the whole's baseline does.

What acts from an instant on bends a baseline that is fitted to all of it: from a drive that answers 40 ms later, say,
both halves are told wrongly, impacts are made up, and no direction leads to the cause. The first part knows nothing of
it yet. With its baseline the rest departs from some instant on, as the cause has it.
"""

from functools import partial

import numpy as np

from stillarm.diagnosis.data.measured import first_part
from stillarm.diagnosis.data.split import Split, interleaved
from stillarm.diagnosis.events.impacts import fit_with_impacts, impacts_while_moving
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import Fit, carried_over, make_data
from stillarm.diagnosis.physics.copies import shared_out

_PARTS = (0.5, 0.25)  # of the recording
_LEAST_S, _LEAST_SWINGS = 5.0, 15.0  # of a part
_CLEANER, _NO_WORSE = 0.5, 1.1  # of the power that is left in a part: in one channel; in each
# quantities that are as before whatever sets in, and those of the part itself
_KEPT = ("modes.", "drive.", "accelerometer.", "camera.", "start.", "jump.")
_JUDGED = ("acceleration", "deflection", "displacement", "joint_position", "joint_velocity")


def early_baseline(baseline: Fit, split: Split) -> Fit | None:
    """The whole recording as the baseline of the longest such part foretells it; None where there is none."""
    world = baseline.world
    if world.measured.pair:
        return None
    swing_s = 1.0 / baseline.value("modes.0.frequency_hz")
    least_s = max(_LEAST_S, _LEAST_SWINGS * swing_s)
    ends_s = [share * world.measured.duration_s for share in _PARTS]
    ends_s = [end_s for end_s in ends_s if end_s >= least_s]
    for end_s, part in zip(ends_s, shared_out(partial(_of_a_part, baseline), ends_s), strict=True):
        if part is None or not _is_cleaner(part, baseline):
            continue
        made_up = impacts_while_moving(part)
        before_s = made_up[0] * world.measured.cycle_s - swing_s if made_up else end_s
        sets_in = bool(made_up) and before_s > least_s  # before the part's end
        earlier = _of_a_part(baseline, before_s) if sets_in else None
        return _of_the_whole(earlier or part, baseline, split)
    return None


def _of_a_part(baseline: Fit, end_s: float) -> Fit | None:
    """The baseline of the recording up to a time, s; None where that lacks a channel."""
    world = baseline.world
    part = world.with_measured(first_part(world.measured, end_s), ())
    if set(part.channels) != set(world.channels):
        return None
    return fit_with_impacts(part, interleaved(part.measured.duration_s))


def _is_cleaner(one: Fit, baseline: Fit) -> bool:
    """Whether a fit of the first part leaves less there."""
    shares = []
    for name in _JUDGED:
        if (now := one.channel(name)) is None or (then := baseline.channel(name)) is None:
            continue
        off, was = now.off, then.off[: len(now.off)]
        both = np.isfinite(off) & np.isfinite(was)
        if both.any():
            shares.append(float(np.mean(off[both] ** 2)) / max(float(np.mean(was[both] ** 2)), 1e-300))
    return bool(shares) and min(shares) < _CLEANER and max(shares) < _NO_WORSE


def _of_the_whole(one: Fit, baseline: Fit, split: Split) -> Fit:
    """The recording with the rig as in its first part, and the impacts of that; later those that fell while the joint
    rested: a wrong model of moves makes up one at each."""
    world, part = baseline.world, one.world
    doubtful = impacts_while_moving(baseline)
    later = [i for i in world.impacts if i > part.measured.cycles and i not in doubtful]
    whole = world.changed(impacts=tuple(sorted({*part.impacts, *later})), strokes=world.strokes)
    values = {name: one.value(name) for name in part.space.names(_KEPT)}
    start = whole.space.with_values(carried_over(baseline, whole), values)
    return fit(make_data(whole, split), start, whole.baseline_names(), iterations=0, colour=baseline.colour)
