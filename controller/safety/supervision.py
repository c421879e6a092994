"""Decides for the step in each cycle whether it may move and damp: health, tests of the damping, and states."""

from functools import partial
from math import sqrt

from stillarm.common.files.configuration import Controller as ControllerSettings
from stillarm.common.files.model import Model
from stillarm.controller.estimation.estimate import Estimate
from stillarm.controller.safety.energy import EnergyTest
from stillarm.controller.safety.health import Health
from stillarm.controller.safety.machine import StateMachine
from stillarm.controller.safety.saturation import SaturationTest
from stillarm.controller.safety.table import BIT_OF, Event, State

_POSITION_SLACK_RAD = 0.01  # rad: a joint at its limit may be slightly beyond it
_QUIET_RAD_S = 1e-4
# looked up once: to read an enumeration's member costs as much as a call
_IDLE, _PREFLIGHT, _FAULT = State.IDLE, State.PREFLIGHT, State.FAULT


class Supervision:
    """Ensures that nothing moves without grounds."""

    def __init__(
        self, model: Model, settings: ControllerSettings, length_m: float, *, identified_only: bool = False
    ) -> None:
        """Use the model's drive and first mode. identified_only: whether to refuse an uncommissioned model."""
        cycle_s, safety = model.timing.cycle_s, settings.safety
        self._drive = model.drive
        self._w = model.arm.modes[0].angular_frequency
        self._make_health = partial(Health, cycle_s, settings.damping.stale_after_s)
        self._health = self._make_health()
        self._make_energy = partial(EnergyTest, model, length_m)
        self._energy = self._make_energy()
        self._saturation = SaturationTest(cycle_s)
        self._machine = StateMachine(cycle_s, arm_at_start=settings.arm_at_start)
        self._needed = (BIT_OF[Event.VISION_STALE] if "vision" in safety.checks_before_arming else 0) | (
            BIT_OF[Event.ACCELEROMETER_DEAD] if "accelerometer" in safety.checks_before_arming else 0
        )
        self._needs_accelerometer = "accelerometer" in safety.checks_before_arming
        self._quiet_after_cycles = round(1.0 / model.arm.modes[0].frequency_hz / cycle_s)
        self._quiet_cycles = 0
        self._found = 0
        self._refused = 0 if model.identified or not identified_only else _UNCOMMISSIONED
        self._damped = False

    @property
    def state(self) -> State:
        """The state after the last cycle."""
        return self._machine.state

    def begin_anew(self, time_s: float) -> None:
        """Forget the previous cycles. State and permission remain: only the operator clears a fault."""
        self._health = self._make_health(time_s if self._health.sampled else float("-inf"))
        self._energy = self._make_energy()
        self._saturation.restart()
        self._quiet_cycles = self._found = 0
        self._damped = False

    def see_image(self, time_s: float) -> None:
        """A visual sample with a measurement was read."""
        self._health.see_image(time_s)

    def begin_cycle(
        self,
        time_s: float,
        elapsed: int,
        acceleration_m_s2: float,
        joint_position_rad: float,
        joint_age_s: float,
        estimate: Estimate,
        operator: int,
    ) -> StateMachine:
        """The state of the controller in this cycle, and what it may do."""
        machine = self._machine
        missing = (
            self._health.missing(time_s, elapsed, acceleration_m_s2, joint_age_s, estimate)
            | self._found
            | self._refused
        )
        before = machine.state
        at_rest = before is _IDLE or before is _PREFLIGHT
        ready = at_rest and self._ready(missing, joint_position_rad)
        machine.step(elapsed, missing, operator, ready=ready, damping=self._damped)
        if before is _FAULT and machine.state is not before:
            self._energy.restart()
            self._saturation.restart()
        return machine

    def _ready(self, missing: int, joint_position_rad: float) -> bool:
        """The checks before arming that are not grounds, and those that the configuration adds."""
        drive = self._drive
        placed = (
            drive.min_position_rad - _POSITION_SLACK_RAD
            <= joint_position_rad
            <= drive.max_position_rad + _POSITION_SLACK_RAD
        )
        sampled = self._health.sampled or not self._needs_accelerometer
        return placed and sampled and not missing & self._needed

    def end_cycle(
        self,
        elapsed: int,
        *,
        acceleration_m_s2: float,
        joint_velocity_rad_s: float,
        reference_rad_s: float,
        active: bool,
        full: bool,
        at_limit: bool,
        estimate: Estimate,
    ) -> None:
        """Store the action of the damping, for the decision in the next cycle."""
        if -_QUIET_RAD_S < reference_rad_s < _QUIET_RAD_S:
            self._quiet_cycles += elapsed
        else:
            self._quiet_cycles = 0
        self._damped = active
        acting = active and full and self._quiet_cycles > self._quiet_after_cycles
        q, rate = estimate.deflection_m, estimate.deflection_rate_m_s / self._w
        amplitude = sqrt(q * q + rate * rate)
        self._found = 0
        if self._energy.grows(elapsed, acceleration_m_s2, joint_velocity_rad_s, acting, amplitude):
            self._found = _GROWING
        if self._saturation.lasts(elapsed, acting and at_limit, amplitude):
            self._found |= _SATURATED


_GROWING, _SATURATED = BIT_OF[Event.GROWING], BIT_OF[Event.SATURATED]
_UNCOMMISSIONED = BIT_OF[Event.UNCOMMISSIONED]
