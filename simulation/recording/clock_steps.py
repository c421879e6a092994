"""clock_step on the controller's side: the rows of a recording made in virtual time, with a clock that jumps.

The loop itself counts cycles and is not affected. A live rig cannot step the controller's clock, only the camera's
(frame_timing_effects).
"""

from typing import TypeVar

import msgspec

from stillarm.common.causes.clock_step import law
from stillarm.common.files.configuration import Rig
from stillarm.common.files.effects import Values, effects_of
from stillarm.common.files.model import Model
from stillarm.common.recording.topics import FrameSample
from stillarm.common.user_error import UserError

Row = TypeVar("Row", bound=msgspec.Struct)


class ClockSteps:
    """Adds each step to the times at or after its onset.

    clock "frames": received_s and started_s of the frames. "all": every time on the controller's clock, in all rows.
    """

    def __init__(self, model: Model) -> None:
        """As the model's effects name them."""
        steps = effects_of(model, "clock_step")
        self._all = [step for step in steps if step["clock"] == "all"]
        self._frames = self._all + [step for step in steps if step["clock"] == "frames"]

    def row(self, row: Row) -> Row:
        """A row of /fast or /estimate, as the stepping clock dates it."""
        if not self._all:
            return row
        return msgspec.structs.replace(row, time_s=_stepped(row.time_s, self._all))  # type: ignore[attr-defined]

    def frame(self, row: FrameSample) -> FrameSample:
        """A row of /frames, as the stepping clock dates it."""
        if not self._frames:
            return row
        return msgspec.structs.replace(
            row,
            time_s=_stepped(row.time_s, self._all),
            received_s=_stepped(row.received_s, self._frames),
            started_s=_stepped(row.started_s, self._frames),
        )


def refuse_step_of_absent_stamps(model: Model, rig: Rig, name: str) -> None:
    """Raise UserError where the camera's clock is to step but no stamp shows it; `name` stands for the model's file."""
    if not rig.scene.stamped and any(step["clock"] == "camera" for step in effects_of(model, "clock_step")):
        raise UserError(
            f'{name}: effects: clock_step: clock = "camera": the simulated camera stamps nothing; '
            "set rig.scene.stamped = true in the configuration"
        )


def refuse_step_of_controller_clock(model: Model, name: str) -> None:
    """Raise UserError if a live rig is asked to step the controller's clock, which it cannot."""
    for step in effects_of(model, "clock_step"):
        if step["clock"] != "camera":
            raise UserError(
                f'{name}: effects: clock_step: clock = "{step["clock"]}": a live rig cannot step the controller\'s '
                "clock; `stillarm simulate` can, in virtual time"
            )


def _stepped(time_s: float, steps: list[Values]) -> float:
    return time_s + float(sum(law(time_s, step["onset_s"], step["step_s"]) for step in steps))
