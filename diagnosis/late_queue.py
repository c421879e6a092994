"""A triggered camera's queue that from some instant on holds more images than it did: each comes as late after its own
request as the further ones take, and shows what it was asked for.

Nothing but the arrivals tells, by a step for good of whole frames beside a delay that wanders. A clock that was set
would show in the requests, too, and leave the time between the two alone.
"""

from math import hypot

from diagnosis.arrival_steps import step_of_arrivals
from diagnosis.fit import Fit
from diagnosis.repeated_stamps import MOST_HELD, Held

_SURE = 2.0  # standard deviations of the step
_WHOLE = 0.25  # frames: a step that is known less well may be of any number


def late_queue(baseline: Fit) -> Held | None:
    """The first frame that the longer queue delays, and by how many frames, if the arrivals step so."""
    world = baseline.world
    step = step_of_arrivals(baseline) if world.measured.frames.asked else None
    if step is None:
        return None
    rate_hz = world.model.camera.frame_rate_hz
    size, noted = step.step_s * rate_hz, world.measured.cycle_s * rate_hz
    doubt, frames = hypot(step.std_s * rate_hz, 0.5 * noted), round(size)
    whole = doubt < _WHOLE and abs(size - frames) < _SURE * doubt
    return Held(step.index, frames) if whole and 1 <= frames <= MOST_HELD else None
