"""What a model file states of a driven joint, as numbers of the grey box: a departure from them is a cause.

With J the inertia that the joint shows to a rigid arm, m_i a clamped-free mode's mass at the tip, p_i its participation
and L the arm's length, the hub's own inertia is J - sum m_i p_i^2 L^2.
"""

from dataclasses import dataclass
from math import log, nan

import msgspec

from stillarm.common.files.model import Model
from stillarm.common.user_error import UserError
from stillarm.diagnosis.driven.signals import Driven


@dataclass(frozen=True)
class Stated:
    """numbers: as the model has them. fixed: those of them that no baseline refits. modes: how many it has."""

    numbers: dict[str, float]
    fixed: tuple[str, ...]
    modes: int


def stated_by(model: Model, driven: Driven, name: str) -> Stated | None:
    """The model's joint; None for a model that states none. Raises UserError for one that no rig can have."""
    drive, length = model.drive, model.arm.length_m
    if drive.kind == "velocity" or drive.inertia_kg_m2 is msgspec.UNSET:
        return None
    heavy = [one for one in model.arm.modes if one.modal_mass_kg is not msgspec.UNSET]
    carried = []
    for one in heavy:
        if length is None:
            raise UserError(f"{name}: arm.length_m: needed where a mode has a modal_mass_kg, and absent")
        carried.append(float(one.modal_mass_kg or 0.0) * (one.participation * length) ** 2)
    hub = drive.inertia_kg_m2 - sum(carried)
    if hub <= 0.0:
        raise UserError(
            f"{name}: drive.inertia_kg_m2 = {drive.inertia_kg_m2:g}: the modes alone carry {sum(carried):g} kg m^2; "
            "give the inertia of the joint with its arm"
        )
    viscous = _or(drive.viscous_n_m_s, 0.0) + _or(drive.back_emf_n_m_s, 0.0)
    numbers = {
        "gain": _or(drive.torque_per_input, 1.0) / hub,
        "damping": viscous / hub,
        "coulomb": _or(drive.coulomb_n_m, 0.0) / hub,
        "lag": _or(drive.amplifier_lag_s, 0.0),
        "hub_inertia_kg_m2": hub,
    }
    for output in driven.outputs:
        if output.kind == "motor":
            numbers[f"scale {output.name}"] = _or(drive.gear_ratio, 1.0)
        elif output.stated:
            numbers[f"scale {output.name}"] = 1.0
    if drive.input_limit is not msgspec.UNSET:
        numbers["limit"] = drive.input_limit
    bends = any(one.kind == "deflection" for one in driven.outputs)
    for i, (mode, inertia) in enumerate(zip(heavy, carried, strict=True), 1):
        numbers[f"log_w_{i}"] = log(mode.angular_frequency)
        numbers[f"zeta_{i}"] = mode.damping_ratio
        numbers[f"follows_{i}"] = mode.participation * (length or nan) if bends else 1.0
        numbers[f"carries_{i}"] = inertia / hub
    known = any(one.stated for one in driven.outputs if one.kind in ("position", "motor", "velocity"))
    fixed = ("damping", *(f"carries_{i}" for i in range(1, len(heavy) + 1))) if known else ()
    if known and driven.drive_stated:
        fixed += ("gain",)
    fixed += tuple(f"scale {one.name}" for one in driven.outputs if one.stated)
    if not driven.drive_stated:  # counts of a converter, say: what a unit of them is nobody knows
        del numbers["gain"]
        numbers.pop("limit", None)
    return Stated(numbers, fixed, len(heavy))


def _or(value: float | msgspec.UnsetType, default: float) -> float:
    return default if isinstance(value, msgspec.UnsetType) else float(value)
