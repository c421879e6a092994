"""The controller's step function: takes a cycle's sensor values, returns the command; and what keeps its method going.

It runs live, in virtual time and in replay, and uses no clock, socket, device or file.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite, nan

import msgspec

from stillarm.common.datagrams.messages import Adjustment
from stillarm.common.files.configuration import Controller as ControllerSettings
from stillarm.common.files.driven_joint import commanded_joint
from stillarm.common.files.effects import declared
from stillarm.common.files.model import Model, length_of
from stillarm.common.user_error import UserError
from stillarm.controller.command.damping import DampingStatus, JointDamping
from stillarm.controller.command.dither import STILL, check_dither, dither_on
from stillarm.controller.command.limits import CommandLimits
from stillarm.controller.command.motion import Motion
from stillarm.controller.estimation.estimate import (
    DelayEstimate,
    Estimate,
    Method,
    Observation,
    OutlivesSupervisor,
    Status,
)
from stillarm.controller.estimation.methods import make_method
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.input.plausible_input import PlausibleInput
from stillarm.controller.joint.joint_motion import JointMotion
from stillarm.controller.safety.adjusting import Adjusted, Adjusting
from stillarm.controller.safety.supervision import Supervision
from stillarm.controller.safety.table import Event, State


@dataclass(slots=True)
class CycleOutput:
    """The output of a cycle: the command for the joint, and the estimate behind it.

    predicted_deflection_m: the deflection at the time of the joint's response (the drive's lead after the cycle)
    reason: the missing ground or the cause of the state; None if nothing is wrong
    adjusted: the answer to an operator's adjustment; None in cycles without one
    """

    command_rad_s: float
    damping_rad_s: float
    damping_status: DampingStatus
    estimate: Estimate
    predicted_deflection_m: float
    state: State = State.PREFLIGHT
    reason: Event | None = None
    adjusted: Adjusted | None = None


class Controller:
    """Subtracts the joint's motion, estimates, checks permission, predicts, damps and limits, once a cycle."""

    def __init__(
        self,
        model: Model,
        settings: ControllerSettings,
        model_name: str = "model",
        *,
        identified_only: bool = False,
    ) -> None:
        """model: of the rig. identified_only: damp only with a commissioned model.

        Raises UserError for an unknown method or a model without length.
        """
        model = declared(model)
        self._model, self._model_name = model, model_name
        self._cycle_s = model.timing.cycle_s
        commanded_joint(model, model_name)
        self._length = length = length_of(model, model_name)
        self._input = PlausibleInput(model, length)
        self._supervision = Supervision(model, settings, length, identified_only=identified_only)
        check_dither(settings.dither, model)
        self._dither_settings = settings.dither
        self._adjusting = Adjusting(settings, self._cycle_s)
        self._limits = CommandLimits(model.drive, self._cycle_s)
        self._begin(0.0)

    def _begin(self, joint_position_rad: float) -> None:
        """Start at rest, without measurements. joint_position_rad: position of the joint until it is reported."""
        model, settings = self._model, self._adjusting.settings
        self.joint = JointMotion(model, self._length, joint_position_rad)
        self.method: Method = self._made(settings)
        self._damping = JointDamping(model, settings.damping, self._model_name)
        self._motion = Motion(model, settings.reference_shaping)
        self._dither = STILL

    def _made(self, settings: ControllerSettings) -> Method:
        """A new method of the settings' name."""
        model, name = self._model, self._model_name
        return MethodAcrossRestarts(lambda: make_method(settings.method, model, settings, name))

    @property
    def settings(self) -> ControllerSettings:
        """The settings in force: as configured, with an operator's adjustments."""
        return self._adjusting.settings

    def _adjusted(self, asked: Adjustment, cycle: int) -> Adjusted | None:
        """Change method and gain if there are grounds to; the answer, None for a request that only repeats itself."""
        adjusting = self._adjusting
        before = adjusting.settings
        answer = adjusting.judge(asked, cycle, self._supervision.state)
        if answer is None or answer.refused:
            return answer
        settings = answer.settings
        try:
            method = self._made(settings) if settings.method != before.method else self.method
            if settings.damping != before.damping:
                self._damping.adjust(settings.damping.added_damping_ratio)
        except UserError as error:
            return adjusting.refuse(asked, str(error))
        self.method = method
        adjusting.settings = settings
        return answer

    @property
    def refused(self) -> list[int]:
        """Number of input values refused since the start, by stillarm.controller.input.plausible_input.Field."""
        return self._input.refused

    def step(self, read: CycleInput) -> CycleOutput:
        """Process one cycle. Cycle numbers increase; skipped cycles are never passed.

        Implausible values count as missing. After a long pause everything restarts except state and permission.
        """
        read, elapsed, begin_anew = self._input.admit(read)
        time_s = read.cycle * self._cycle_s
        if begin_anew:
            self._begin(self.joint.position_rad)
            self._supervision.begin_anew(time_s)
        adjusted = self._adjusted(read.adjustment, read.cycle) if read.adjustment is not None else None
        joint, damping, supervision = self.joint, self._damping, self._supervision
        joint.begin_cycle(read.cycle, read.joint_position_rad)
        estimate = self.method.update(
            Observation(read.cycle, time_s, read.acceleration_m_s2, read.samples, joint, read.deflection_m)
        )
        for sample in read.samples:
            if sample.restarted:
                damping.begin_anew()
            if sample.measured:
                damping.see_sample(time_s)
                supervision.see_image(time_s)
        allowed = supervision.begin_cycle(
            time_s,
            elapsed,
            read.acceleration_m_s2,
            joint.position_rad,
            read.joint_age_s,
            estimate,
            read.operator,
        )
        reference = self._motion.reference(
            read.cycle, elapsed, read.reference_rad_s, allowed, self._limits, damping, joint
        )
        damping.see_cycle(read.cycle, estimate, read.samples, joint)
        velocity, status = damping.velocity_rad_s(
            estimate,
            time_s,
            read.damping_allowed and allowed.may_damp,
            joint.position_rad,
            read.joint_age_s,
            joint.play,
        )
        wanted = reference + velocity
        if self._dither_settings.enabled:
            wanted += self._dither_rad_s(
                estimate.accelerometer_lost and status is _ACTIVE, elapsed, allowed.may_move
            )
        command = self._limits.bound(wanted, joint.position_rad)
        joint.send(command)
        moved, active = read.joint_velocity_rad_s, status is _ACTIVE
        supervision.end_cycle(
            elapsed,
            acceleration_m_s2=read.acceleration_m_s2,
            joint_velocity_rad_s=moved if isfinite(moved) else joint.velocity_rad_s,
            reference_rad_s=reference,
            active=active,
            full=damping.full,
            at_limit=damping.at_limit or command != wanted,
            estimate=estimate,
        )
        return CycleOutput(
            command,
            velocity,
            status,
            estimate,
            damping.predicted_m(estimate),
            allowed.state,
            allowed.reason,
            adjusted,
        )

    def _dither_rad_s(self, wanted: bool, elapsed: int, may_move: bool) -> float:
        """The dither's part of the command. It ends at once if the joint may not move."""
        if not may_move:
            self._dither = STILL
            return 0.0
        self._dither, velocity = dither_on(
            self._dither, wanted, elapsed * self._cycle_s, self._dither_settings
        )
        return velocity


class MethodAcrossRestarts:
    """Restarts the method at the first sample of a restarted supervisor, whose displacements have another zero: in one
    fit, images with two zeros look like a large vibration, and would be damped as one. A restart takes 5 to 200 us. A
    method that can separate the zero of the images from everything else is told of it instead, and keeps what it knows.

    A method whose numbers have left the range of floats would never recover, and is restarted as well.
    failures: number of such restarts.
    """

    def __init__(self, make: Callable[[], Method]) -> None:
        """make: returns a new method."""
        self._make = make
        self._method = make()
        self.failures = 0

    def update(self, observation: Observation) -> Estimate:
        """As the method's."""
        samples = observation.samples
        for place in range(len(samples) - 1, -1, -1):
            if samples[place].restarted:
                self._see_new_zero()
                if place:  # samples of the previous supervisor
                    observation = msgspec.structs.replace(observation, samples=samples[place:])
                break
        try:
            estimate = self._method.update(observation)
        except (ArithmeticError, ValueError):  # LinAlgError is a ValueError
            return self._failed()
        if estimate.status in _KNOWN and not isfinite(
            estimate.deflection_m + estimate.deflection_rate_m_s + estimate.delay.delay_s
        ):
            return self._failed()
        return estimate

    def _see_new_zero(self) -> None:
        if isinstance(self._method, OutlivesSupervisor):
            self._method.see_new_zero()
        else:
            self._method = self._make()

    def _failed(self) -> Estimate:
        self.failures += 1
        self._method = self._make()
        return Estimate(DelayEstimate(nan, nan, Status.INVALID), status=Status.INVALID, reason=_FAILED)


_ACTIVE = DampingStatus.ACTIVE  # looked up once: to read an enumeration's member costs as much as a call
_FAILED = "numbers out of range: started again"
_KNOWN = (Status.ESTIMATED, Status.HELD)
