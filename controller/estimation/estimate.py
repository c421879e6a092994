"""The input and output of a method in every cycle."""

from enum import StrEnum
from math import nan
from typing import NamedTuple, Protocol, runtime_checkable

import msgspec

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.controller.joint.joint_motion import JointMotion

MOST_UNDATED = 4
"""Number of frames to keep until a method dates them (Estimate.dated): the one in progress, the last two that arrive in
one cycle (the method uses no more), and one to spare."""


class Status(StrEnum):
    """Reliability of a delay or a prediction."""

    UNESTIMATED = "unestimated"  # nothing measured yet; the model's prior stands in
    ESTIMATED = "estimated"
    HELD = "held"  # not observable at present; the last value is used, with growing uncertainty
    INVALID = "invalid"  # not to be used


class Trust(StrEnum):
    """Reliability of an estimate's stated deviation."""

    STARTING = "starting"  # too few data yet; the configured delay stands in
    SETTLED = "settled"
    DOUBTFUL = "doubtful"  # errors exceed the stated deviation, which is raised in the meantime


class DelayEstimate(NamedTuple):
    """Capture delay (reading of a visual sample minus mid-exposure) with its standard deviation, s."""

    delay_s: float
    std_s: float
    status: Status


class FrameDelay(NamedTuple):
    """The delay of a frame, by its number."""

    frame: int
    delay: DelayEstimate


class Observation(msgspec.Struct, gc=False):
    """The input of every method in a cycle: raw measurements, and the joint's motion with its history.

    acceleration_m_s2 is NaN without a sample; samples are the visual samples read in this cycle, in order.
    deflection_m: measured directly, for instance by a strain gauge; otherwise NaN.
    """

    cycle: int
    time_s: float
    acceleration_m_s2: float
    samples: list[VisualSample]
    joint: JointMotion
    deflection_m: float = nan


class Estimate(msgspec.Struct, frozen=True, gc=False):
    """A method's output of a cycle.

    deflection_m (sum of the modes, zero-mean) and deflection_rate_m_s at the observation's time; NaN if unknown.
    deflection_std_m: its standard deviation. status: of the deflection. reason: what limits the delay or the
    deflection, or which sensor is faulty; empty without a reason. accelerometer_lost: the method works without it,
    since it is dead or shows no vibration. dated: the frames whose delay was determined in this cycle, some cycles
    after they were read; None from a method that dates a frame in the cycle of its reading. static_m: the part of
    deflection_m that a lasting force holds; the arm vibrates about it, and it cannot be damped. trust: result of the
    method's own checks of its deviations; None from a method without such checks.
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
        """The deflection without the part that a lasting force holds."""
        return self.deflection_m - self.static_m

    @property
    def trusted(self) -> Trust:
        """The method's trust; for a method without checks it follows from the status of its delay."""
        if self.trust is not None:
            return self.trust
        return Trust.STARTING if self.delay.status is Status.UNESTIMATED else Trust.SETTLED


@runtime_checkable
class OutlivesSupervisor(Protocol):
    """A method that goes on with a new supervisor's images: camera, arm and sensors are the same, the zero is not."""

    def see_new_zero(self) -> None:
        """The next image counts its displacement from another zero."""


class Method(Protocol):
    """An estimator of delay and deflection. One call a cycle, in order, without other state."""

    def update(self, observation: Observation) -> Estimate:
        """Process one cycle and return the estimate."""
