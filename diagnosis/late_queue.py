"""A triggered camera's queue that from some instant on holds more images than it did: each comes as late after its own
request as the further ones take, and shows what it was asked for.

Nothing but the arrivals tells, by a step for good of whole frames beside a delay that wanders. A clock that was set
would show in the requests, too, and leave the time between the two alone; where the images have stamps of their own,
the requests would step against those.
"""

from math import hypot

import numpy as np

from stillarm.diagnosis.arrival_steps import SIDE, ArrivalStep, step_of_arrivals
from stillarm.diagnosis.fit import Fit
from stillarm.diagnosis.measured import Frames
from stillarm.diagnosis.repeated_stamps import MOST_HELD, Held
from stillarm.diagnosis.robust import step_at

_SURE = 2.0  # standard deviations of the step
_ALIKE, _FEWEST = 0.25, 5  # of the step; frames on either side
_WHOLE = 0.25  # frames: a step that is known less well may be of any number


def late_queue(baseline: Fit) -> Held | None:
    """The first frame that the longer queue delays, and by how many frames, if the arrivals step so."""
    world = baseline.world
    frames = world.measured.frames
    step = step_of_arrivals(baseline)
    if step is None or not (frames.asked or _requests_keep_to_stamps(frames, step)):
        return None
    rate_hz = world.model.camera.frame_rate_hz
    size, noted = step.step_s * rate_hz, world.measured.cycle_s * rate_hz
    doubt, held = hypot(step.std_s * rate_hz, 0.5 * noted), round(size)
    whole = doubt < _WHOLE and abs(size - held) < _SURE * doubt
    return Held(step.index, held) if whole and 1 <= held <= MOST_HELD else None


def _requests_keep_to_stamps(frames: Frames, step: ArrivalStep) -> bool:
    """Whether both are known about a step, and go on alike there."""
    apart = frames.started_s - frames.captured_s
    before, after = apart[max(0, step.index - SIDE) : step.index], apart[step.index : step.index + SIDE]
    if min(np.isfinite(before).sum(), np.isfinite(after).sum()) < _FEWEST:
        return False
    return abs(step_at(apart, step.index, SIDE)) < _ALIKE * abs(step.step_s)
