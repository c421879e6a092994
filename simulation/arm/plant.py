"""The simulated arm for a loop: a joint that obeys a velocity, a torque, a current or a voltage, and a flexible link,
moved on cycle by cycle.

The equations are those of stillarm.simulation.arm.stepper and torque_drive; this module turns the model file into the
stepper's arrays, delays commands by the dead time, and reads the result. It obeys the model file's effects that act in
the arm or its drive.
"""

from collections import deque
from collections.abc import Callable
from functools import partial
from math import copysign, isnan
from operator import mul

import numpy as np
from numpy.typing import NDArray

from stillarm.common.causes import CAUSES
from stillarm.common.files.beam import tip_slopes_per_m
from stillarm.common.files.driven_joint import commanded_joint, stated_or
from stillarm.common.files.effects import acting, declared, effect_of, laws_at
from stillarm.common.files.effects_check import check_effects
from stillarm.common.files.model import Model, length_of
from stillarm.common.user_error import UserError
from stillarm.simulation.arm.compiled_laws import laws_of
from stillarm.simulation.arm.effect_clock import EffectClock
from stillarm.simulation.arm.state import make_arm, modes_of
from stillarm.simulation.arm.stepper import advance, look, strike
from stillarm.simulation.arm.torque_drive import advance_by_input, joint_numbers, obeyed_numbers
from stillarm.simulation.arm.torque_joint import laws_of as laws_of_joint

Array = NDArray[np.float64]
_MODES = 5  # place of the first deflection in what `observe` fills


class Plant:
    """The arm's true state, moved on by whole cycles. Deterministic."""

    def __init__(self, model: Model, name: str = "model") -> None:
        """At rest at joint position zero (or the end stop nearest to it). `name` stands for the file in
        messages.

        model: the true parameters, with any effects. Raises UserError for a model without a length or with an
        effect that the catalogue does not allow.
        """
        check_effects(model.effects, name)
        model = declared(model)
        joint = commanded_joint(model, name)
        self._length_m = length_of(model, name)
        self.cycle_s = model.timing.cycle_s
        self.cycle = 0
        self.modal_forces_m_s2 = [0.0] * len(model.arm.modes)
        """External acceleration of each mode, held over the next cycles: a disturbance."""
        self.effect_clock = EffectClock()
        """When the recording started, on the plant's time_s."""
        self._slopes = tip_slopes_per_m(self._length_m, len(model.arm.modes))
        self._rules = laws_at(model, "command")
        if joint is not None and self._rules:
            raise UserError(
                f'{name}: effects: one of them acts on velocity commands, but drive.kind = "{model.drive.kind}"; '
                "remove it"
            )
        self._max_velocity = model.drive.max_velocity_rad_s
        backlash = effect_of(model, "gear_backlash")
        gap_rad = backlash["gap_rad"] if backlash else stated_or(model.drive.gear_play_rad, 0.0)
        self._encoder_on_motor = bool(backlash and backlash["behind_encoder"])
        rows = [
            (one.frequency_hz, one.damping_ratio, one.participation * self._length_m)
            for one in model.arm.modes
        ]
        self._count = len(rows)
        effects = acting(model)
        self._arm, whole = make_arm(model.drive, self.cycle_s, np.array(rows), laws_of(effects), gap_rad)
        self._under_way = deque([0.0] * whole)
        self._acting = 0.0
        first_hz = model.arm.modes[0].frequency_hz
        self._limits = [
            (identifier, cause.limit, first_hz, cause.arguments(values))
            for identifier, values in effects
            if (cause := CAUSES[identifier]).limit is not None
        ]
        self._seen_array = np.zeros(5 + 3 * len(rows))
        move_on: Callable[..., None] = advance
        driven: tuple[Array, ...] = ()
        if joint is not None:
            obeyed = obeyed_numbers(model, joint, name)
            move_on = advance_by_input
            driven = joint_numbers(joint, obeyed, np.array(rows)[:, 2]), laws_of_joint(obeyed)
        self._move_on = partial(move_on, self._arm, *driven)
        self._in_drive = self._obeyed if joint is None else float
        # All that is ever called is compiled before any clock runs: an impact's first call stood it still for 50 ms.
        move_on(self._arm.copy(), *driven, 0.0, 0.0, 0.0, self._seen_array)
        strike(self._arm.copy(), 0, 0.0, 0.0)
        self._shaken_m_s2 = self.modal_forces_m_s2
        self._see()

    def advance(self, command: float) -> None:
        """Move on by one cycle, over which the command is held: a joint velocity, rad/s, or the drive's input in its
        unit, as the model's drive.kind says; an input that is NaN brakes. Raises ValueError if a velocity is no number;
        UserError if an effect has taken the arm beyond the range of its equation.
        """
        self._under_way.append(self._in_drive(command))
        before, self._acting = self._acting, self._under_way.popleft()
        self._shake()
        self._move_on(self._since_start_s, before, self._acting, self._seen_array)
        self.cycle += 1
        self._seen = self._seen_array.tolist()
        for identifier, broken, first_hz, own in self._limits:
            if said := broken(self.effect_time_s, first_hz, self._seen[_MODES], *own):
                raise UserError(f"effects: {identifier}: {said}")

    def _obeyed(self, velocity_rad_s: float) -> float:
        """What a velocity command becomes in the drive, rad/s."""
        limit = self._max_velocity
        if not -limit <= velocity_rad_s <= limit:
            if isnan(velocity_rad_s):
                raise ValueError("the drive's command is not a number")
            velocity_rad_s = copysign(limit, velocity_rad_s)
        for rule in self._rules:
            velocity_rad_s = rule(velocity_rad_s)
        return velocity_rad_s

    def strike(self, mode: int, deflection_m: float) -> None:
        """An impact on mode number `mode` (1 = first), after which it rings with amplitude `deflection_m`
        (signed).

        The modal velocity jumps by w * deflection_m. Raises IndexError for a mode that the arm does not have.
        """
        if not 1 <= mode <= self._count:
            raise IndexError(f"mode {mode}: the arm has modes 1 to {self._count}")
        strike(self._arm, mode - 1, self._since_start_s, deflection_m)
        self._see()

    def _shake(self) -> None:
        """Hand on the disturbance, where it is another one."""
        if self._shaken_m_s2 is not self.modal_forces_m_s2:
            self._shaken_m_s2 = self.modal_forces_m_s2
            modes_of(self._arm)["force"] = self._shaken_m_s2

    def _see(self) -> None:
        look(self._arm, self._since_start_s, self._seen_array)
        self._seen = self._seen_array.tolist()

    @property
    def time_s(self) -> float:
        """Time since the start, s: whole cycles."""
        return self.cycle * self.cycle_s

    @property
    def _since_start_s(self) -> float:
        """Time from the recording's start, s, before it negative."""
        return self.time_s - self.effect_clock.origin_s

    @property
    def effect_time_s(self) -> float:
        """Time from the recording's start, s; zero before it."""
        return self.effect_clock.at(self.time_s)

    @property
    def joint_position_rad(self) -> float:
        """theta."""
        return self._seen[0]

    @property
    def joint_velocity_rad_s(self) -> float:
        """theta'."""
        return self._seen[1]

    @property
    def joint_acceleration_rad_s2(self) -> float:
        """theta'' at the end of the cycle past; an impact on an end stop, or across a gap, is a jump of theta'
        and not in it."""
        return self._seen[2]

    @property
    def encoder_position_rad(self) -> float:
        """The encoder's angle: theta, or the motor's position if the encoder sits before the gear's play."""
        return self._seen[3 if self._encoder_on_motor else 0]

    @property
    def encoder_velocity_rad_s(self) -> float:
        """Its rate."""
        return self._seen[4 if self._encoder_on_motor else 1]

    @property
    def modal_deflections_m(self) -> list[float]:
        """q_i at the tip, one for each mode."""
        return self._seen[_MODES : _MODES + self._count]

    @property
    def modal_rates_m_s(self) -> list[float]:
        """q_i', one for each mode."""
        return self._seen[_MODES + self._count : _MODES + 2 * self._count]

    @property
    def deflection_m(self) -> float:
        """Sum of q_i."""
        return sum(self._seen[_MODES : _MODES + self._count])

    @property
    def tip_position_m(self) -> float:
        """s = length * theta + sum q_i."""
        return self._length_m * self.joint_position_rad + self.deflection_m

    @property
    def tip_acceleration_m_s2(self) -> float:
        """s'' = length * theta'' + sum q_i'', from the equations at the present state."""
        if self._shaken_m_s2 is not self.modal_forces_m_s2:
            self._shake()
            self._see()
        return self._length_m * self._seen[2] + sum(self._seen[_MODES + 2 * self._count :])

    @property
    def tip_angle_rad(self) -> float:
        """theta plus the slope of the bent arm at its tip: how far the camera turns."""
        bent: float = sum(map(mul, self._slopes, self._seen[_MODES : _MODES + self._count]))
        return self._seen[0] + bent
