"""A buffer that begins to hand over old images with their own stamps: an exposure comes twice, all later ones late."""

from dataclasses import dataclass, replace

import numpy as np

from stillarm.diagnosis.measured import Frames, Measured
from stillarm.diagnosis.robust import step_at

MOST_HELD = 4
"""Frames that a queue is taken to hold at most, where nothing but the images tells."""

_SAME_S = 1e-4  # between stamps of one exposure
_MOST_FRAMES = 32
_ASIDE = 15  # frames
_STAYS = 0.5  # of the frames held: so much later images stay


@dataclass(frozen=True)
class Held:
    """From the frame at place `first` on, images are `frames` exposures older than they were."""

    first: int
    frames: int


def held_back(frames: Frames, period_s: float) -> Held | None:
    """The first exposure that comes again as a later frame, if the stamps stay behind from there on."""
    stamps = frames.captured_s
    if frames.asked or np.isfinite(stamps).sum() < 2 * _ASIDE:
        return None
    late = frames.received_s - stamps
    for i in (np.flatnonzero(np.diff(stamps) < 0.5 * period_s) + 1).tolist():
        before = stamps[max(0, i - _MOST_FRAMES) : i][::-1]
        again = np.flatnonzero(np.abs(before - stamps[i]) < _SAME_S)
        if not len(again):
            continue
        many = int(again[0]) + 1
        if step_at(late, i, _ASIDE) > _STAYS * many * period_s:
            return Held(i, many)
    return None


def without(measured: Measured, held: Held, period_s: float) -> Measured:
    """The recording with the images as late as they were before."""
    late = np.where(np.arange(len(measured.frames)) >= held.first, held.frames * period_s, 0.0)
    frames = measured.frames
    return replace(measured, frames=replace(frames, received_s=frames.received_s - late))
