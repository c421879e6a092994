"""Frames that arrivals alone miscounted, and that the images count right.

Where the delay wanders by nearly a period within a second, arrivals look as after a lost frame, and all later images
are dated a period late; where several are lost in a row, arrivals look as if a clock had been set, and all later images
are dated early. They tell, far better than arrivals do: each is older, or younger, than it was taken for.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.fit import CHANGED_NATS, Fit, Split, fit, make_data
from stillarm.diagnosis.image_dating import image_nats, older_from
from stillarm.diagnosis.impacts import carried_over
from stillarm.diagnosis.robust import step_at
from stillarm.diagnosis.world import World

Counts = NDArray[np.int64]

_WHOLE = 0.25  # frames
_NEAR_S = 2.0  # between where images grow older and where the arrivals seemed to jump
_MOST = 4
_LATE, _ASIDE = 1.5, 15  # periods; frames: fewer would have been seen, or may be the delay's own wander


def recounted(baseline: Fit, split: Split) -> Fit:
    """The baseline without the losses that the images speak against, and with those that they speak for."""
    for _ in range(_MOST):
        others = [
            fit(make_data(world, split), carried_over(baseline, world), world.baseline_names())
            for world in _miscounted(baseline)
        ]
        best = max(others, key=image_nats, default=None)
        if best is None or image_nats(best) < image_nats(baseline) + CHANGED_NATS:
            break
        baseline = best
    return baseline


def _miscounted(baseline: Fit) -> list[World]:
    """The worlds with a loss less, or with losses more, than arrivals told; none where they were not asked."""
    world, frames = baseline.world, baseline.world.measured.frames
    if not world.frame_clock.counted or "displacement" not in world.channels:
        return []
    if not frames.counted and np.any(np.diff(frames.counter) > 1):
        return []  # the counter itself tells what was lost
    steps = [*_with_one_loss_less(baseline), *_with_losses_where_late(world)]
    return [_with_steps(world, one) for one in steps]


def _with_steps(world: World, steps: Counts) -> World:
    counter = np.concatenate(([0], np.cumsum(steps))) + world.frame_clock.counts[0]
    frames = replace(world.measured.frames, counter=counter, counted=True)
    return world.with_measured(replace(world.measured, frames=frames))


def _with_one_loss_less(baseline: Fit) -> list[Counts]:
    """The counts' steps without the loss where images grow older; none where no loss was told by arrivals, or none lies
    there."""
    world, frames = baseline.world, baseline.world.measured.frames
    steps = np.diff(world.frame_clock.counts)
    told = np.flatnonzero(steps > 1)
    found = older_from(baseline) if len(told) else None
    if found is None:
        return []
    index, older_s = found
    older = older_s * world.model.camera.frame_rate_hz
    lost = told[int(np.argmin(np.abs(told + 1 - index)))]
    far_s = abs(float(frames.received_s[lost + 1] - frames.received_s[index]))
    if round(older) < 1 or abs(older - round(older)) > _WHOLE or far_s > _NEAR_S:
        return []
    steps[lost] -= min(round(older), int(steps[lost]) - 1)
    return [steps]


def _with_losses_where_late(world: World) -> list[Counts]:
    """The counts' steps with about as many frames lost as arrivals are late from there on, where they are so the most
    after a gap as long; none where they nowhere are."""
    steps = np.diff(world.frame_clock.counts)
    late = (world.measured.frames.received_s - world.frame_clock.grid_s) * world.model.camera.frame_rate_hz
    gaps = np.flatnonzero(np.diff(late) > _LATE).tolist()
    stays = [step_at(late, gap + 1, _ASIDE) for gap in gaps]
    if max(stays, default=0.0) < _LATE:
        return []
    many, gap = max(zip(stays, gaps, strict=True))
    found = []
    for lost in (int(many), int(many) + 1):
        more = steps.copy()
        more[gap] += lost
        found.append(more)
    return found
