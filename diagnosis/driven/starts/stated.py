"""What a model file states of a driven joint, as numbers of the grey box: a departure from them is a cause.

With J the inertia that the joint shows to a rigid arm, m_i a clamped-free mode's mass at the tip, p_i its participation
and L the arm's length, the hub's own inertia is J - sum m_i p_i^2 L^2.
"""

from dataclasses import dataclass
from math import log, nan

import msgspec

from stillarm.common.files.model import Model
from stillarm.common.user_error import UserError
from stillarm.diagnosis.driven.recording.signals import Driven


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
    for i, (mode, inertia) in enumerate(zip(heavy, carried, strict=True), 1):
        numbers[f"log_w_{i}"] = log(mode.angular_frequency)
        numbers[f"stated_log_w_{i}"] = numbers[f"log_w_{i}"]
        numbers[f"zeta_{i}"] = mode.damping_ratio
        numbers[f"carries_{i}"] = inertia / hub
    if drive.input_limit is not msgspec.UNSET:
        numbers["limit"] = drive.input_limit
    fixed = ["damping", *(f"carries_{i}" for i in range(1, len(heavy) + 1))]
    tips = [one.participation * (length or nan) for one in heavy]
    fixed += _sensors(numbers, driven, _or(drive.gear_ratio, 1.0), tips, length)
    if driven.drive_stated and any(one.stated for one in driven.outputs):
        fixed.append("gain")
    if not driven.drive_stated:  # counts of a converter, say: what a unit of them is nobody knows
        del numbers["gain"]
        numbers.pop("limit", None)
    return Stated(numbers, tuple(fixed), len(heavy))


def _sensors(
    numbers: dict[str, float], driven: Driven, gear_ratio: float, tips: list[float], length: float | None
) -> list[str]:
    """Adds what the sensors see of the stated joint and arm; returns which of it no baseline refits.

    tips: m/rad, how each mode's tip follows the joint. A sensor of known unit sees the stated arm in its own size: a
    mode's participation may be off, but then it carries another inertia, too (carried_by).
    """
    fixed = []
    tip = {one.kind: one.stated for one in driven.outputs if one.kind in ("deflection", "acceleration")}
    in_metres = tip.get("deflection", tip.get("acceleration", False)) and length is not None
    for i, follows in enumerate(tips, 1):
        numbers[f"follows_{i}"] = follows if in_metres or "deflection" in tip else 1.0
        if in_metres:
            numbers[f"stated_follows_{i}"] = follows
    for one in driven.outputs:
        if one.kind == "acceleration" and one.stated and length is not None:
            numbers[f"direct {one.name}"] = length
            fixed.append(f"direct {one.name}")
            if in_metres:
                fixed += [f"share_{i} {one.name}" for i in range(1, len(tips) + 1)]
        if one.kind == "motor":
            numbers[f"scale {one.name}"] = gear_ratio
        elif one.stated:
            numbers[f"scale {one.name}"] = 1.0
        if one.stated:
            fixed.append(f"scale {one.name}")
    return fixed


def _or(value: float | msgspec.UnsetType, default: float) -> float:
    return default if isinstance(value, msgspec.UnsetType) else float(value)
