"""The simulated arm: a velocity-controlled joint and a flexible link of any number of bending modes.

    theta'' = clip(decay (command late by the dead time - theta'), max_acceleration), stopped by the end stops
    q_i'' + 2 zeta_i w_i q_i' + w_i^2 q_i = - participation_i length theta'' + forces
    s = length theta + sum q_i

The linear part is solved exactly over each cycle (plant_drive, plant_modes), so neither a high frequency nor
a short dead time asks for a shorter step; so are backlash (gear_play) and dry friction (dry_friction). Force
terms that depend on the state (plant_forces) are kicks of half a step before and after it (Strang splitting),
or, beside dry friction, held at their value midway; either is of second order in the step. The effects of the
model file are obeyed in so far as they are the plant's.
"""

from common.beam import tip_slopes_per_m
from common.effects import check_effects, declared, effect_of
from common.model import Model, length_of
from simulation.drive_rules import command_rules
from simulation.dry_friction import DryFriction
from simulation.effect_clock import EffectClock
from simulation.frequency_change import FrequencyChange
from simulation.gear_play import GearPlay
from simulation.plant_drive import JointDrive
from simulation.plant_effects import ForceTerm
from simulation.plant_forces import force_terms
from simulation.plant_modes import ModalOscillator


class Plant:
    """The arm's true state, moved on by whole cycles. Pure and deterministic."""

    def __init__(self, model: Model, name: str = "model") -> None:
        """At rest at joint position zero (or the end stop nearest to it). `name` stands for the file in
        messages.

        model: the true parameters, with any effects. Raises UserError for a model without a length or with an
        effect that the catalogue does not allow.
        """
        check_effects(model.effects, name)
        model = declared(model)
        length = length_of(model, name)
        self.cycle_s = model.timing.cycle_s
        self.cycle = 0
        self.modal_forces_m_s2 = [0.0] * len(model.arm.modes)
        """External acceleration of each mode, held over the next cycles: a disturbance."""
        self.effect_clock = EffectClock()
        """When the recording started, on the plant's time_s."""
        self._length_m = length
        self._joint = JointDrive(model.drive, self.cycle_s, command_rules(model))
        decay, durations = self._joint.decay_per_s, self._joint.usual_durations_s
        self._declared_modes = model.arm.modes
        self._modes = [ModalOscillator(mode, length, decay, durations) for mode in model.arm.modes]
        self._slopes = tip_slopes_per_m(length, len(self._modes))
        self._forces = tuple(force_terms(model))
        friction, backlash = effect_of(model, "coulomb_damping"), effect_of(model, "gear_backlash")
        force = friction["force_per_mass_m_s2"] if friction else 0.0
        self._friction = DryFriction(force) if force else None
        self._play = GearPlay(backlash["gap_rad"]) if backlash and backlash["gap_rad"] else None
        self._encoder_on_motor = bool(backlash and backlash["behind_encoder"])
        change = FrequencyChange(model)
        self._change = change if change.happens else None
        self._ratios = (1.0, 1.0)

    def advance(self, command_rad_s: float) -> None:
        """Move on by one cycle, over which the joint velocity command is held. ValueError when it is no
        number."""
        motor_rad_s = self._joint.velocity_rad_s
        stretches = self._joint.advance(command_rad_s)
        if self._play is not None:
            stretches = self._play.follow(motor_rad_s, stretches)
        if self._change is not None:
            self._tune(*self._change.ratios(self._effect_time_s(0.5)))
        forces = self.modal_forces_m_s2
        if self._friction is not None and self._forces:
            forces = [forces[0] + self._force_midway(self._friction), *forces[1:]]
        elif self._forces:
            self._kick(self._forces, self._effect_time_s(0.0))
        for mode, force in zip(self._modes, forces, strict=True):
            for stretch in stretches:
                if self._friction is not None and mode is self._modes[0]:
                    self._friction.advance(mode, stretch, force)
                else:
                    mode.advance(stretch, force)
        if self._forces and self._friction is None:
            self._kick(self._forces[::-1], self._effect_time_s(0.5))  # a mirror image: of second order
        self.cycle += 1

    def strike(self, mode: int, deflection_m: float) -> None:
        """A blow on mode number `mode` (1 = first), after which it rings with amplitude `deflection_m`
        (signed).

        The modal velocity jumps by w * deflection_m. Raises IndexError for a mode that the arm does not have.
        """
        if mode < 1:
            raise IndexError(f"mode {mode}: modes count from 1")
        struck = self._modes[mode - 1]
        struck.rate_m_s += struck.angular_frequency * deflection_m

    @property
    def time_s(self) -> float:
        """Time since the start, s: whole cycles."""
        return self.cycle * self.cycle_s

    @property
    def effect_time_s(self) -> float:
        """Time from the recording's start, s; zero before it."""
        return self._effect_time_s(0.0)

    @property
    def joint_position_rad(self) -> float:
        """theta."""
        return self._joint.position_rad - (self._play.ahead_rad if self._play is not None else 0.0)

    @property
    def joint_velocity_rad_s(self) -> float:
        """theta'."""
        return self._joint.velocity_rad_s if self._play is None or self._play.in_contact else 0.0

    @property
    def joint_acceleration_rad_s2(self) -> float:
        """theta'' at the end of the cycle past; an impact on an end stop, or across a gap, is a jump of theta'
        and not in it."""
        return self._joint.acceleration_rad_s2 if self._play is None or self._play.in_contact else 0.0

    @property
    def encoder_position_rad(self) -> float:
        """What the encoder shows: theta, or the motor's position where it sits before the gear's play."""
        return self._joint.position_rad if self._encoder_on_motor else self.joint_position_rad

    @property
    def encoder_velocity_rad_s(self) -> float:
        """Its rate."""
        return self._joint.velocity_rad_s if self._encoder_on_motor else self.joint_velocity_rad_s

    @property
    def modal_deflections_m(self) -> list[float]:
        """q_i at the tip, one for each mode."""
        return [mode.deflection_m for mode in self._modes]

    @property
    def modal_rates_m_s(self) -> list[float]:
        """q_i', one for each mode."""
        return [mode.rate_m_s for mode in self._modes]

    @property
    def deflection_m(self) -> float:
        """Sum of q_i."""
        return sum(mode.deflection_m for mode in self._modes)

    @property
    def tip_position_m(self) -> float:
        """s = length * theta + sum q_i."""
        return self._length_m * self.joint_position_rad + self.deflection_m

    @property
    def tip_acceleration_m_s2(self) -> float:
        """s'' = length * theta'' + sum q_i'', from the equations at the present state."""
        joint = self.joint_acceleration_rad_s2
        total = self._length_m * joint
        for mode, force in zip(self._modes, self.modal_forces_m_s2, strict=True):
            total += mode.acceleration_m_s2(joint, force)
        if self._forces:
            total += self._present_force()
        if self._friction is not None:
            first = self._modes[0]
            pull = first.acceleration_m_s2(joint, self.modal_forces_m_s2[0])
            pull += self._present_force()
            total += self._friction.acceleration_m_s2(first.rate_m_s, pull)
        return total

    @property
    def tip_angle_rad(self) -> float:
        """theta plus the slope of the bent arm at its tip: how far the camera turns."""
        bent = sum(slope * mode.deflection_m for slope, mode in zip(self._slopes, self._modes, strict=True))
        return self.joint_position_rad + bent

    def _effect_time_s(self, cycles_on: float) -> float:
        return self.effect_clock.at((self.cycle + cycles_on) * self.cycle_s)

    def _tune(self, first: float, others: float) -> None:
        if (first, others) != self._ratios:
            self._ratios = (first, others)
            for i, (mode, as_declared) in enumerate(zip(self._modes, self._declared_modes, strict=True)):
                mode.tune((others if i else first) * as_declared.angular_frequency)

    def _kick(self, terms: tuple[ForceTerm, ...], effect_time_s: float) -> None:
        mode, duration_s = self._modes[0], 0.5 * self.cycle_s
        for term in terms:
            mode.rate_m_s += duration_s * term.acceleration_m_s2(
                mode.angular_frequency, mode.deflection_m, mode.rate_m_s, effect_time_s, duration_s
            )

    def _force_midway(self, friction: DryFriction) -> float:
        """The force terms halfway through the cycle, to hold over it: a kick would tear loose what friction holds."""
        mode, half_s = self._modes[0], 0.5 * self.cycle_s
        rate = mode.rate_m_s
        pull = mode.acceleration_m_s2(self.joint_acceleration_rad_s2, self.modal_forces_m_s2[0])
        pull += self._present_force()
        change = pull + friction.acceleration_m_s2(rate, pull)
        deflection = mode.deflection_m + half_s * rate
        return self._force_at(deflection, rate + half_s * change, self._effect_time_s(0.5))

    def _present_force(self) -> float:
        """What the force terms give the first mode."""
        mode = self._modes[0]
        return self._force_at(mode.deflection_m, mode.rate_m_s, self.effect_time_s)

    def _force_at(self, deflection_m: float, rate_m_s: float, effect_time_s: float) -> float:
        w = self._modes[0].angular_frequency
        return sum(
            term.acceleration_m_s2(w, deflection_m, rate_m_s, effect_time_s, 0.0) for term in self._forces
        )
