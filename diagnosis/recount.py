"""Frames that were taken for lost by their arrivals alone, and that the images show to have come.

Where the delay wanders by nearly a period within a second, arrivals look as after a lost frame, and all later images
are dated a period late. They tell, far better than arrivals do: each is older than it was taken for, by that period.
"""

from dataclasses import replace

import numpy as np

from diagnosis.fit import CHANGED_NATS, Fit, Split, fit, make_data
from diagnosis.image_dating import image_nats, older_from
from diagnosis.impacts import carried
from diagnosis.world import World

_WHOLE = 0.25  # frames
_NEAR_S = 2.0  # between where images grow older and where the arrivals seemed to jump
_MOST = 4


def recounted(baseline: Fit, split: Split) -> Fit:
    """The baseline without the losses that the images speak against."""
    for _ in range(_MOST):
        world = _with_one_loss_less(baseline)
        if world is None:
            break
        other = fit(make_data(world, split), carried(baseline, world), world.baseline_names())
        if image_nats(other) < image_nats(baseline) + CHANGED_NATS:
            break
        baseline = other
    return baseline


def _with_one_loss_less(baseline: Fit) -> World | None:
    """The world in which the frames that were taken for lost where images grow older were none; None where no loss was
    told by arrivals, or none lies there."""
    world, frames = baseline.world, baseline.world.measured.frames
    if not world.frame_clock.counted or "displacement" not in world.channels:
        return None
    if not frames.counted and np.any(np.diff(frames.counter) > 1):
        return None  # the counter itself tells what was lost
    counts = world.frame_clock.counts
    steps = np.diff(counts)
    told = np.flatnonzero(steps > 1)
    found = older_from(baseline) if len(told) else None
    if found is None:
        return None
    index, older_s = found
    older = older_s * world.model.camera.frame_rate_hz
    lost = told[int(np.argmin(np.abs(told + 1 - index)))]
    far_s = abs(float(frames.received_s[lost + 1] - frames.received_s[index]))
    if round(older) < 1 or abs(older - round(older)) > _WHOLE or far_s > _NEAR_S:
        return None
    steps[lost] -= min(round(older), int(steps[lost]) - 1)
    counter = np.concatenate(([0], np.cumsum(steps))) + counts[0]
    measured = replace(world.measured, frames=replace(frames, counter=counter, counted=True))
    return World(measured, world.model, world.impacts)
