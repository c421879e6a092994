"""What a model file states of a joint that a torque, a current or a voltage drives, as numbers of its equation.

    J_hub theta'' = torque_per_input u - d theta' - friction + sum_i m_i b_i (2 zeta_i w_i q_i' + w_i^2 q_i)
    J_hub         = J - sum_i m_i b_i^2,        b_i = participation_i * length

J is the inertia that the joint shows while the arm is rigid, m_i a clamped-free mode's mass at the tip. A mode without
a `modal_mass_kg` does not pull at the joint.
"""

from dataclasses import dataclass

import msgspec

from stillarm.common.files.model import Mode, Model, refuse_driven_effects
from stillarm.common.user_error import UserError


@dataclass(frozen=True)
class DrivenJoint:
    """hub_inertia_kg_m2: J_hub. torque_per_input: N m per unit of the command. damping_n_m_s: d, with what a winding
    brakes with. carried_kg_m2: m_i b_i^2 of the modes that have a mass, in their order, zero for the others. limit: of
    the command, in its unit, None for none.
    """

    hub_inertia_kg_m2: float
    torque_per_input: float
    damping_n_m_s: float
    coulomb_n_m: float
    lag_s: float
    limit: float | None
    carried_kg_m2: tuple[float, ...]

    @property
    def inertia_kg_m2(self) -> float:
        """J, of the joint with its arm rigid."""
        return self.hub_inertia_kg_m2 + sum(self.carried_kg_m2)

    def most_n_m(self, name: str) -> float:
        """The largest torque that a command gives. Raises UserError without a limit; `name` stands for the file."""
        if self.limit is None:
            raise UserError(
                f"{name}: drive.input_limit: needed where the velocity loop commands the joint, and absent; give the "
                "largest input that the drive may have for as long as it asks for it"
            )
        return abs(self.torque_per_input) * self.limit


def driven_joint(model: Model, name: str) -> DrivenJoint | None:
    """The model's joint; None for one that follows a velocity. `name` stands for the file in messages.

    Raises UserError for a joint that no rig can have.
    """
    drive = model.drive
    if drive.kind == "velocity" or drive.inertia_kg_m2 is msgspec.UNSET:
        return None
    carried = tuple(_carried(one, model.arm.length_m, name) for one in model.arm.modes)
    hub = drive.inertia_kg_m2 - sum(carried)
    if hub <= 0.0:
        raise UserError(
            f"{name}: drive.inertia_kg_m2 = {drive.inertia_kg_m2:g}: the modes alone carry {sum(carried):g} kg m^2; "
            "give the inertia of the joint with its arm"
        )
    return DrivenJoint(
        hub,
        stated_or(drive.torque_per_input, 1.0),
        stated_or(drive.viscous_n_m_s, 0.0) + stated_or(drive.back_emf_n_m_s, 0.0),
        stated_or(drive.coulomb_n_m, 0.0),
        stated_or(drive.amplifier_lag_s, 0.0),
        None if drive.input_limit is msgspec.UNSET else drive.input_limit,
        carried,
    )


def commanded_joint(model: Model, name: str) -> DrivenJoint | None:
    """The joint that the velocity loop commands and the simulated plant is; None for one that follows a velocity.

    Raises UserError for a joint that neither knows: one behind a position loop, with a command that gives no torque, or
    one that follows a velocity under an effect that only the others have.
    """
    drive = model.drive
    if drive.kind == "velocity":
        refuse_driven_effects(model, name)
    if drive.kind == "position":
        raise UserError(
            f'{name}: drive.kind = "position": only `stillarm diagnose` knows such a joint; the controller and the '
            'simulation need "velocity", "torque", "current" or "voltage"'
        )
    joint = driven_joint(model, name)
    if joint is not None and joint.torque_per_input == 0.0:
        raise UserError(
            f"{name}: drive.torque_per_input = 0: no command would turn the joint; give the N m per unit of it, "
            "negative where a positive command turns it backward"
        )
    return joint


def stated_or(value: float | msgspec.UnsetType, default: float) -> float:
    """A key's value, or what stands for one that is absent."""
    return default if isinstance(value, msgspec.UnsetType) else float(value)


def _carried(mode: Mode, length_m: float | None, name: str) -> float:
    """m_i b_i^2 of a mode, kg m^2."""
    if mode.modal_mass_kg is msgspec.UNSET:
        return 0.0
    if length_m is None:
        raise UserError(f"{name}: arm.length_m: needed where a mode has a modal_mass_kg, and absent")
    return mode.modal_mass_kg * (mode.participation * length_m) ** 2
