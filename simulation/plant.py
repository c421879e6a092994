"""The simulated arm: a velocity-controlled joint and a flexible link of any number of bending modes.

    theta'' = clip(decay (command late by the dead time - theta'), max_acceleration), stopped by the end stops
    q_i'' + 2 zeta_i w_i q_i' + w_i^2 q_i = - participation_i length theta'' + forces
    s = length theta + sum q_i

The linear part is solved exactly over each cycle (plant_drive, plant_modes), so neither a high frequency nor
a short dead time asks for a shorter step. Force terms that depend on the state are kicks of half a step
before and after it (Strang splitting, second order in the step).
"""

from collections.abc import Sequence

from common.beam import tip_slopes_per_m
from common.model import Model, length_of
from simulation.plant_drive import JointDrive
from simulation.plant_effects import CommandRule, ForceTerm, refuse_unsupported_effects
from simulation.plant_modes import ModalOscillator


class Plant:
    """The arm's true state, moved on by whole cycles. Pure and deterministic."""

    def __init__(
        self,
        model: Model,
        name: str = "model",
        *,
        forces: Sequence[ForceTerm] = (),
        rules: Sequence[CommandRule] = (),
    ) -> None:
        """At rest at joint position zero (or the end stop nearest to it). `name` stands for the file in
        messages.

        model: the true parameters. Raises UserError for a model without a length or with an unsupported
        effect.
        """
        refuse_unsupported_effects(model, name)
        length = length_of(model, name)
        self.cycle_s = model.timing.cycle_s
        self.cycle = 0
        self.modal_forces_m_s2 = [0.0] * len(model.arm.modes)
        """External acceleration of each mode, held over the next cycles: a disturbance."""
        self._length_m = length
        self._joint = JointDrive(model.drive, self.cycle_s, rules)
        decay, durations = self._joint.decay_per_s, self._joint.usual_durations_s
        self._modes = [ModalOscillator(mode, length, decay, durations) for mode in model.arm.modes]
        self._slopes = tip_slopes_per_m(length, len(self._modes))
        self._forces = tuple(forces)

    def advance(self, command_rad_s: float) -> None:
        """Move on by one cycle, over which the joint velocity command is held. ValueError when it is no
        number."""
        stretches = self._joint.advance(command_rad_s)
        if self._forces:
            self._kick(self.time_s, 0.5 * self.cycle_s)
        for mode, force in zip(self._modes, self.modal_forces_m_s2, strict=True):
            for stretch in stretches:
                mode.advance(stretch, force)
        self.cycle += 1
        if self._forces:
            self._kick(self.time_s, 0.5 * self.cycle_s)

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
    def joint_position_rad(self) -> float:
        """theta."""
        return self._joint.position_rad

    @property
    def joint_velocity_rad_s(self) -> float:
        """theta'."""
        return self._joint.velocity_rad_s

    @property
    def joint_acceleration_rad_s2(self) -> float:
        """theta'' at the end of the cycle past; an impact on an end stop is a jump of theta' and not in
        it."""
        return self._joint.acceleration_rad_s2

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
        return self._length_m * self._joint.position_rad + self.deflection_m

    @property
    def tip_acceleration_m_s2(self) -> float:
        """s'' = length * theta'' + sum q_i'', from the equations at the present state."""
        joint = self._joint.acceleration_rad_s2
        total = self._length_m * joint
        for mode, force in zip(self._modes, self.modal_forces_m_s2, strict=True):
            total += mode.acceleration_m_s2(joint, force)
        if self._forces:
            total += sum(
                self._state_force(number, self.time_s, 0.0) for number in range(1, len(self._modes) + 1)
            )
        return total

    @property
    def tip_angle_rad(self) -> float:
        """theta plus the slope of the bent arm at its tip: how far the camera turns."""
        bent = sum(slope * mode.deflection_m for slope, mode in zip(self._slopes, self._modes, strict=True))
        return self._joint.position_rad + bent

    def _kick(self, time_s: float, duration_s: float) -> None:
        kicks = [self._state_force(number, time_s, duration_s) for number in range(1, len(self._modes) + 1)]
        for mode, kick in zip(self._modes, kicks, strict=True):
            mode.rate_m_s += kick * duration_s

    def _state_force(self, number: int, time_s: float, duration_s: float) -> float:
        mode = self._modes[number - 1]
        return sum(
            term.acceleration_m_s2(number, mode.deflection_m, mode.rate_m_s, time_s, duration_s)
            for term in self._forces
        )
