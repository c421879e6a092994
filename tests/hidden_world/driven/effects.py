"""The causes: how each enters the equations or a sensor, in which forms, between which sizes, and what is told of it.

A size is relative to what the plain rig does, so that one scale of sizes serves every rig (Scales).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

from tests.hidden_world.driven.dynamics import Laws
from tests.hidden_world.driven.rig import Arm, Channel, Effect, Rig, Values

Changes = dict[str, float]
_RIPPLE_TURNS = (12.0, 72.0)


def _nothing(rig: Rig, effect: Effect) -> Changes:
    """Inertia and sensors are changed elsewhere."""
    return {}


def _coulomb(rig: Rig, effect: Effect) -> Changes:
    other = effect.size * (1.0 if effect.form == "symmetric" else 0.2 + 0.4 * effect.chance[0])
    up, down = (effect.size, other) if effect.sign > 0.0 else (other, effect.size)
    return {"dry_up": up, "dry_down": down, "dry_width": _width(rig, effect.size)}


def _stribeck(rig: Rig, effect: Effect) -> Changes:
    share, slow = 0.5 + effect.chance[0], rig.speed * (0.15 + 0.35 * effect.chance[1])
    width = _width(rig, effect.size * (1.0 + share))
    return {
        "dry_up": effect.size,
        "dry_down": effect.size,
        "stiction": share,
        "stiction_w": slow,
        "dry_width": width,
    }


def _ripple(rig: Rig, effect: Effect) -> Changes:
    low, high = _RIPPLE_TURNS
    return {
        "ripple": effect.size,
        "ripple_turns": float(round(low + (high - low) * effect.chance[0])),
        "ripple_phase": 2.0 * np.pi * effect.chance[1],
        "ripple_second": 0.0 if effect.form == "sine" else 0.5,
    }


def _dead_zone(rig: Rig, effect: Effect) -> Changes:
    return {"dead_zone": effect.size, "dead_shift": float(effect.form == "shifted")}


@dataclass(frozen=True)
class Kind:
    """low, high: bounds of the size. unit: what the size is relative to, in words.

    laws: what the effect changes in the equations, its size in its own unit. stated: shows against a stated nominal
    rig only, so one is handed over.
    """

    forms: tuple[str, ...]
    low: float
    high: float
    unit: str
    laws: Callable[[Rig, Effect], Changes] = _nothing
    stated: bool = False


_OF_TORQUE = "rms of the motor's torque"
CAUSES = {
    "joint_coulomb_friction": Kind(("symmetric", "by_direction"), 2e-3, 0.6, _OF_TORQUE, _coulomb),
    "joint_stribeck_friction": Kind(("symmetric",), 2e-3, 0.5, _OF_TORQUE, _stribeck),
    "joint_viscous_friction": Kind(
        ("more", "less"),
        0.02,
        3.0,
        "stated friction",
        lambda rig, e: {"viscous": rig.drive.viscous * factor(e)},
        stated=True,
    ),
    "gear_backlash": Kind(("play",), 1e-3, 0.3, "rms of the joint's angle", lambda rig, e: {"gap": e.size}),
    "torque_ripple": Kind(("sine", "two_harmonics"), 2e-3, 0.5, _OF_TORQUE, _ripple),
    "torque_offset": Kind(("constant",), 2e-3, 0.5, _OF_TORQUE, lambda rig, e: {"offset": e.sign * e.size}),
    "gravity_load": Kind(("pendulum",), 2e-3, 1.0, _OF_TORQUE, lambda rig, e: {"gravity": e.size}),
    "drive_saturation": Kind(
        ("clip",), 0.02, 0.7, "taken off the largest command", lambda rig, e: {"limit": e.size}
    ),
    "amplifier_dead_zone": Kind(("cut", "shifted"), 3e-3, 0.6, "rms of the command", _dead_zone),
    "encoder_quantisation": Kind(("round",), 1e-5, 0.3, "standard deviation of the joint's angle"),
    "inertia_change": Kind(("tip_mass", "hub"), 0.01, 1.0, "inertia of all that turns", stated=True),
    "sensor_scale": Kind(("more", "less"), 0.003, 0.5, "stated scale", stated=True),
    "sensor_lag": Kind(("first_order",), 1e-4, 0.1, "s"),
    "channel_delay": Kind(("delay",), 1e-4, 0.1, "s"),
}
SENSOR_CAUSES = ("encoder_quantisation", "sensor_scale", "sensor_lag", "channel_delay")


@dataclass(frozen=True)
class Scales:
    """Of the plain rig under its excitation: rms of torque (N m), velocity, command, angle; the largest command."""

    torque: float
    velocity: float
    command: float
    angle: float
    peak: float


def absolute(effect: Effect, scales: Scales) -> Effect:
    """The same effect with its size in its own unit: N m, rad, command, or the bare number."""
    by = {
        "joint_coulomb_friction": scales.torque,
        "joint_stribeck_friction": scales.torque,
        "torque_ripple": scales.torque,
        "torque_offset": scales.torque,
        "gravity_load": scales.torque,
        "gear_backlash": scales.angle,
        "encoder_quantisation": scales.angle,
        "amplifier_dead_zone": scales.command,
    }
    if effect.cause == "drive_saturation":
        return replace(effect, size=(1.0 - effect.size) * scales.peak)
    return replace(effect, size=effect.size * by.get(effect.cause, 1.0))


def gear(rig: Rig) -> dict[str, float]:
    """Contact of the teeth: 150 Hz between motor and arm, well damped."""
    motor, link = rig.drive.motor_inertia, rig.drive.hub_inertia + rig.arm.rigid_inertia
    both, w = motor * link / (motor + link), 2.0 * np.pi * 150.0
    return {"gear_stiffness": both * w * w, "gear_damping": 2.0 * 0.3 * both * w}


def factor(effect: Effect) -> float:
    """What 'more' or 'less' by the size multiplies by."""
    return 1.0 + effect.size if effect.form == "more" else 1.0 / (1.0 + effect.size)


def changed_laws(rig: Rig, effect: Effect, laws: Laws) -> Laws:
    """laws with the effect, whose size is absolute; a sensor's effect changes none."""
    return laws._replace(**CAUSES[effect.cause].laws(rig, effect))


def _width(rig: Rig, torque: float) -> float:
    """Over which velocity dry friction turns, rad/s: 1 % of what is usual; more where the integrator asks for it."""
    light = rig.drive.hub_inertia + rig.drive.motor_inertia
    return float(max(0.01 * rig.speed, torque / light * 2.5e-4))


def inertia_changed(rig: Rig, effect: Effect | None) -> tuple[Arm, float, float]:
    """Arm, inertia of the hub and of the motor. A tip mass is stated as what it adds to the inertia."""
    arm, hub, motor = rig.arm, rig.drive.hub_inertia, rig.drive.motor_inertia
    if effect is None or effect.cause != "inertia_change":
        return arm, hub, motor
    more = effect.size * rig.inertia
    if effect.form == "hub":
        return arm, hub + more, motor
    return replace(arm, payload_kg=arm.payload_kg + more / arm.length_m**2), hub, motor


def sensed(effect: Effect, channel: Channel, values: Values, step: float) -> tuple[Values, Channel]:
    """A channel's values at every step, and the channel, as its sensor has them."""
    match effect.cause:
        case "sensor_scale":
            return values * factor(effect), channel
        case "sensor_lag":
            a = np.exp(-step / effect.size)
            return np.asarray(lfilter([1.0 - a], [1.0, -a], values, zi=[a * values[0]])[0]), channel
        case "channel_delay":
            t = step * np.arange(len(values))
            return np.interp(t - effect.size, t, values), channel
        case "encoder_quantisation":
            return values, replace(channel, quantum=effect.size)
    return values, channel


def told(rig: Rig, effect: Effect) -> dict[str, float | str]:
    """The parameters, from the absolute size, each with its unit."""
    size, changed = effect.size, CAUSES[effect.cause].laws(rig, effect)
    by_cause: dict[str, dict[str, float | str]] = {
        "joint_coulomb_friction": {
            "torque_up_n_m": changed.get("dry_up", 0.0),
            "torque_down_n_m": changed.get("dry_down", 0.0),
        },
        "joint_stribeck_friction": {
            "torque_n_m": size,
            "stiction_share": changed.get("stiction", 0.0),
            "stribeck_velocity_rad_s": changed.get("stiction_w", 0.0),
        },
        "joint_viscous_friction": {
            "viscous_n_m_s": changed.get("viscous", 0.0),
            "stated_n_m_s": rig.drive.viscous,
        },
        "gear_backlash": {"gap_rad": size},
        "torque_ripple": {"amplitude_n_m": size, "periods_per_turn": changed.get("ripple_turns", 0.0)},
        "torque_offset": {"torque_n_m": effect.sign * size},
        "gravity_load": {"torque_n_m": size},
        "drive_saturation": {"limit": size, "stated": rig.drive.limit},
        "amplifier_dead_zone": {"width": size},
        "encoder_quantisation": {"step_rad": size},
        "inertia_change": {"added_kg_m2": size * rig.inertia, "stated_kg_m2": rig.inertia},
        "sensor_scale": {"factor": factor(effect)},
        "sensor_lag": {"lag_s": size},
        "channel_delay": {"delay_s": size},
    }
    return by_cause[effect.cause] | ({"channel": effect.channel} if effect.channel else {})
