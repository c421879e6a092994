"""What a model file states of a driven joint, as numbers of the grey box: a departure from them is a cause.

The joint's equation is that of stillarm.common.files.driven_joint.
"""

from dataclasses import dataclass
from math import log, nan

import msgspec

from stillarm.common.files.driven_joint import driven_joint, stated_or
from stillarm.common.files.model import Model
from stillarm.diagnosis.driven.recording.signals import Driven


@dataclass(frozen=True)
class Stated:
    """numbers: as the model has them. fixed: those of them that no baseline refits. modes: how many it has."""

    numbers: dict[str, float]
    fixed: tuple[str, ...]
    modes: int


def stated_by(model: Model, driven: Driven, name: str) -> Stated | None:
    """The model's joint; None for a model that states none. Raises UserError for one that no rig can have."""
    joint, drive, length = driven_joint(model, name), model.drive, model.arm.length_m
    if joint is None:
        return None
    pairs = zip(model.arm.modes, joint.carried_kg_m2, strict=True)
    carrying = [(one, carried) for one, carried in pairs if one.modal_mass_kg is not msgspec.UNSET]
    hub = joint.hub_inertia_kg_m2
    numbers = {
        "gain": joint.torque_per_input / hub,
        "damping": joint.damping_n_m_s / hub,
        "coulomb": joint.coulomb_n_m / hub,
        "lag": joint.lag_s,
        "hub_inertia_kg_m2": hub,
    }
    for i, (mode, inertia) in enumerate(carrying, 1):
        numbers[f"log_w_{i}"] = log(mode.angular_frequency)
        numbers[f"stated_log_w_{i}"] = numbers[f"log_w_{i}"]
        numbers[f"zeta_{i}"] = mode.damping_ratio
        numbers[f"carries_{i}"] = inertia / hub
    if joint.limit is not None:
        numbers["limit"] = joint.limit
    fixed = ["damping", *(f"carries_{i}" for i in range(1, len(carrying) + 1))]
    tips = [one.participation * (length or nan) for one, _ in carrying]
    fixed += _sensors(numbers, driven, stated_or(drive.gear_ratio, 1.0), tips, length)
    if driven.drive_stated and any(one.stated for one in driven.outputs):
        fixed.append("gain")
    if not driven.drive_stated:  # counts of a converter, say: what a unit of them is nobody knows
        del numbers["gain"]
        numbers.pop("limit", None)
    return Stated(numbers, tuple(fixed), len(carrying))


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
