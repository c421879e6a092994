"""What a method gets to see every cycle, and what it says."""

from enum import StrEnum
from math import nan
from typing import NamedTuple, Protocol, runtime_checkable

import msgspec

from common.visual_sample import VisualSample
from controller.joint_motion import JointMotion

MOST_UNDATED = 4
"""Frames to be kept until a method dates them (Estimate.dated): the one that it was at work on, the last two of those
that then come in one cycle (it looks at no more of them), and one to spare."""


class Status(StrEnum):
    """How far a delay or a prediction can be relied on."""

    UNESTIMATED = "unestimated"  # nothing measured yet: the model's prior stands in
    ESTIMATED = "estimated"
    HELD = "held"  # cannot be seen at present: the last one stands, with growing uncertainty
    INVALID = "invalid"  # not to be used


class Trust(StrEnum):
    """Whether an estimate's stated deviation can be relied on."""

    STARTING = "starting"  # too little seen yet: the configured delay stands in
    SETTLED = "settled"
    DOUBTFUL = "doubtful"  # measurements lie further off than was stated; the deviation is raised meanwhile


class DelayEstimate(NamedTuple):
    """Capture delay (reading of a visual sample minus mid-exposure) with its standard deviation, s."""

    delay_s: float
    std_s: float
    status: Status


class FrameDelay(NamedTuple):
    """The delay of the frame of that number."""

    frame: int
    delay: DelayEstimate


class Observation(msgspec.Struct, gc=False):
    """One cycle as every method sees it: raw measurements, and the joint's motion with its history.

    acceleration_m_s2 is NaN where there was no sample; samples are the visual samples read in this cycle, in order.
    deflection_m: measured directly, as by a strain gauge; NaN where it is not.
    """

    cycle: int
    time_s: float
    acceleration_m_s2: float
    samples: list[VisualSample]
    joint: JointMotion
    deflection_m: float = nan


class Estimate(msgspec.Struct, frozen=True, gc=False):
    """What a method says in a cycle.

    deflection_m (sum of the modes, zero-mean) and deflection_rate_m_s at the observation's time; NaN when unknown.
    deflection_std_m: its standard deviation. status: that of the deflection. reason: why the delay or the deflection is
    no better than it is, or which sensor is at fault; empty for nothing to be said. accelerometer_lost: the method does
    without it, as it is dead or shows no vibration. dated: the frames whose delay has been found in this cycle, some
    cycles after they were read; None from a method that says it in the cycle of the frame. static_m: the part of
    deflection_m that a lasting force holds, about which the arm vibrates: it cannot be damped. trust: whether the
    method's own checks bear the deviations out; None from a method that has none.
    """

    delay: DelayEstimate
    deflection_m: float = nan
    deflection_rate_m_s: float = nan
    deflection_std_m: float = nan
    status: Status = Status.UNESTIMATED
    reason: str = ""
    accelerometer_lost: bool = False
    dated: tuple[FrameDelay, ...] | None = None
    static_m: float = 0.0
    trust: Trust | None = None

    @property
    def vibration_m(self) -> float:
        """The deflection about the place at which a lasting force holds the tip."""
        return self.deflection_m - self.static_m

    @property
    def trusted(self) -> Trust:
        """The method's trust; of one that does not check itself, by the status of its delay."""
        if self.trust is not None:
            return self.trust
        return Trust.STARTING if self.delay.status is Status.UNESTIMATED else Trust.SETTLED


@runtime_checkable
class OutlivesSupervisor(Protocol):
    """A method that goes on with a new supervisor's images: camera, arm and sensors are the same, the zero is not."""

    def see_new_zero(self) -> None:
        """The next image counts its displacement from another zero."""


class Method(Protocol):
    """A way from measurements to delay and deflection. One call a cycle, in order, with no other state."""

    def update(self, observation: Observation) -> Estimate:
        """Take in one cycle and say what is known then."""
