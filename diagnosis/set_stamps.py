"""A triggered camera's clock that was set: its stamps step against the requests and the arrivals alike.

Images are dated by their stamps there. If it was the computers' clock that was set, requests and arrivals step against
the stamps just so, and the images keep to the stamps: what they show tells which of the two it was.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.arrival_steps import arrival_step
from stillarm.diagnosis.fit import CHANGED_NATS, WANDER_S, Fit, Split, gain_of_each_block
from stillarm.diagnosis.impacts import fit_with_impacts
from stillarm.diagnosis.laws import OF_STAMPS, LawFound
from stillarm.diagnosis.measured import Frames, Measured
from stillarm.diagnosis.robust import std_about_median, step_at

Array = NDArray[np.float64]

_KNOWN = 0.8  # of the frames
_BESIDE = 60  # frames: a clock may be set in parts, within a second


class SetStamps(NamedTuple):
    """The first frame whose stamp is of the clock that was set, and by how much, s, with its standard deviation."""

    first: int
    step_s: float
    std_s: float


def stamps_apart(frames: Frames) -> Array | None:
    """A camera's stamps less the requests, or less the arrivals where those scatter less, s, (frames,), NaN where
    unknown; None without stamps."""
    apart = [frames.captured_s - other for other in (frames.started_s, frames.received_s)]
    known = [one for one in apart if np.isfinite(one).mean() > _KNOWN]
    if frames.asked or not known:
        return None
    return min(known, key=lambda one: std_about_median(np.diff(one[np.isfinite(one)])))


def set_stamps(frames: Frames, longest_frames: float) -> SetStamps | None:
    """The step of a camera's stamps against the controller's clock; None where they go on alike. longest_frames: that
    the time between them wanders over."""
    apart = stamps_apart(frames)
    step = None if apart is None else arrival_step(apart, longest_frames)
    if apart is None or step is None:
        return None
    return SetStamps(step.index, step_at(apart, step.index, _BESIDE), step.std_s)


def taken_back(measured: Measured, step: SetStamps) -> Measured:
    """The same data, the stamps those of a clock that was never set."""
    stamps = measured.frames.captured_s.copy()
    stamps[step.first :] -= step.step_s
    return replace(measured, frames=replace(measured.frames, captured_s=stamps))


def without_set_stamps(baseline: Fit, split: Split) -> tuple[Fit, list[LawFound]]:
    """The baseline with the stamps that date a triggered camera's images those of a clock that was never set, if the
    images say that it was."""
    world = baseline.world
    frames, clock = world.measured.frames, world.frame_clock
    if clock.counted or clock.arrival or "displacement" not in world.channels:
        return baseline, []
    step = set_stamps(frames, WANDER_S / world.step_s("displacement"))
    if step is None:
        return baseline, []
    other = fit_with_impacts(world.with_measured(taken_back(world.measured, step), ()), split)
    gains = gain_of_each_block(other, baseline)
    gained = float(gains.sum())
    onset = float(frames.received_s[step.first]), world.step_s("displacement")
    law = LawFound("clock_step", {"onset_s": onset, "step_s": (step.step_s, step.std_s)}, gains, OF_STAMPS)
    return (other, [law]) if gained > CHANGED_NATS else (baseline, [])
