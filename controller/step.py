"""The controller's one step function: what the sensors gave in a cycle, and the command that answers it.

It runs live, in virtual time and in replay; it knows no clock, no socket, no device, no file.
"""

from dataclasses import dataclass, field
from math import isfinite, nan

from common.configuration import Controller as ControllerSettings
from common.model import Model, length_of
from common.visual_sample import VisualSample
from controller.damping import DampingStatus, JointDamping
from controller.estimate import Estimate, Observation
from controller.joint_motion import JointMotion
from controller.limits import CommandLimits
from controller.methods import make_method
from controller.shaping import ReferenceShaper


@dataclass(slots=True)
class CycleInput:
    """What a cycle has read. Missing numbers are NaN.

    joint_age_s: age of the drive's report; NaN for a drive that reports nothing
    reference_rad_s: the external joint velocity reference, as given
    damping_allowed: the operator's or schedule's permission
    samples: the visual samples read in this cycle, in order of arrival
    deflection_m: measured directly, as by a strain gauge
    """

    cycle: int
    acceleration_m_s2: float = nan
    joint_position_rad: float = nan
    joint_velocity_rad_s: float = nan
    joint_age_s: float = nan
    reference_rad_s: float = 0.0
    damping_allowed: bool = False
    samples: list[VisualSample] = field(default_factory=list)
    deflection_m: float = nan


@dataclass(slots=True)
class CycleOutput:
    """What a cycle answers: the command for the joint, and the estimate that it rests on.

    predicted_deflection_m: the deflection at which the joint will answer (the drive's lead after the cycle)
    """

    command_rad_s: float
    damping_rad_s: float
    damping_status: DampingStatus
    estimate: Estimate
    predicted_deflection_m: float


class Controller:
    """Takes off the joint's own motion, estimates, predicts, damps, limits: once a cycle."""

    def __init__(self, model: Model, settings: ControllerSettings, model_name: str = "model") -> None:
        """For a model of the rig. Raises UserError for an unknown method or a model without length."""
        self._cycle_s = model.timing.cycle_s
        self.joint = JointMotion(model, length_of(model, model_name))
        self.method = make_method(settings.method, model, settings, model_name)
        self._damping = JointDamping(model, settings.damping, model_name)
        self._shaper = ReferenceShaper(settings.reference_shaping, model.arm.modes[0], self._cycle_s)
        self._limits = CommandLimits(model.drive, self._cycle_s)
        self._cycle: int | None = None

    def step(self, read: CycleInput) -> CycleOutput:
        """One cycle. Cycle numbers increase; those that the loop skipped never come."""
        elapsed = 1 if self._cycle is None else read.cycle - self._cycle
        self._cycle = read.cycle
        time_s = read.cycle * self._cycle_s
        joint, damping = self.joint, self._damping
        joint.begin_cycle(read.cycle, read.joint_position_rad)
        estimate = self.method.update(
            Observation(read.cycle, time_s, read.acceleration_m_s2, read.samples, joint, read.deflection_m)
        )
        for sample in read.samples:
            if sample.measured:
                damping.see_sample(time_s)
        reference = read.reference_rad_s if isfinite(read.reference_rad_s) else 0.0
        reference = self._shaper.shape(read.cycle, reference)
        damping.follow_reference(reference, joint.position_rad, elapsed)
        damping.see_cycle(read.cycle, estimate, read.samples, joint)
        velocity, status = damping.velocity_rad_s(
            estimate, time_s, read.damping_allowed, joint.position_rad, read.joint_age_s
        )
        command = self._limits.bound(reference + velocity, joint.position_rad)
        joint.send(command)
        return CycleOutput(command, velocity, status, estimate, damping.predicted_m(estimate))
