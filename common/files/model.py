"""The model file: one description of the rig, for simulate, replay, calibrate, diagnose and the controller.

Units are SI and stand in every name. The equations that the parameters belong to:

    theta' follows its command as a first-order lag of `bandwidth_hz` after `dead_time_s`
    q_i'' + 2 zeta_i w_i q_i' + w_i^2 q_i = - participation_i * length * theta''   (+ disturbances)
    s = length * theta + sum q_i                                   transverse position of the tip
    acceleration = scale * s''                                     (plus what the sensor adds)
    displacement_px = - scale_px_per_m * s - rotation_px_per_rad * (theta + slope of the tip) + offset
"""

from math import pi
from pathlib import Path
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from stillarm.common.causes.driven import DRIVEN_CAUSES
from stillarm.common.files.effects_check import EffectValue, check_effects
from stillarm.common.files.typed_toml import load_toml
from stillarm.common.user_error import UserError

_SMALLEST_SCALE = 1e-6
_LARGEST = 1e9  # beyond any rig; squares and products of such numbers are still far from an overflow
Positive = Annotated[float, Meta(gt=0.0, le=_LARGEST)]
NonNegative = Annotated[float, Meta(ge=0.0, le=_LARGEST)]
Signed = Annotated[float, Meta(ge=-_LARGEST, le=_LARGEST)]


class Mode(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """One bending mode. Default: first mode of a uniform beam that rotates at its root."""

    frequency_hz: Annotated[float, Meta(ge=0.01, le=400.0)] = 2.6
    damping_ratio: Annotated[float, Meta(ge=0.0, lt=1.0)] = 0.01
    participation: Signed = 1.14
    modal_mass_kg: NonNegative | msgspec.UnsetType = msgspec.UNSET
    """By which it pulls at a joint that is driven by a torque; the mode is clamped-free: that of a hub held still."""

    @property
    def angular_frequency(self) -> float:
        """Undamped angular frequency w, rad/s."""
        return 2.0 * pi * self.frequency_hz


class Arm(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The flexible link. `length_m` may be absent where no deflection is asked for."""

    length_m: Positive | None = None
    modes: Annotated[list[Mode], Meta(min_length=1, max_length=12)] = msgspec.field(
        default_factory=lambda: [Mode()]
    )


class Drive(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The joint and its limits. kind: what the command is; of another kind than "velocity" the keys from
    inertia_kg_m2 on say how the joint follows, all of them referred to the joint, behind the gear.

    inertia_kg_m2: of the joint with the arm rigid. torque_per_input: N m per unit of the command (1 for a torque, the
    motor constant times the gear ratio for a current, that over the winding's resistance for a voltage, the stiffness
    of a position loop). back_emf_n_m_s: what the winding brakes with under a voltage. gear_ratio: turns of
    the motor, which motor_position_rad counts, for one of the joint.
    """

    bandwidth_hz: Positive = 20.0
    dead_time_s: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.002
    max_velocity_rad_s: Positive = 0.6
    max_acceleration_rad_s2: Positive = 20.0
    min_position_rad: Signed = -1.0
    max_position_rad: Signed = 1.0
    kind: Literal["velocity", "torque", "current", "voltage", "position"] = "velocity"
    inertia_kg_m2: Positive | msgspec.UnsetType = msgspec.UNSET
    viscous_n_m_s: NonNegative | msgspec.UnsetType = msgspec.UNSET
    coulomb_n_m: NonNegative | msgspec.UnsetType = msgspec.UNSET
    torque_per_input: Signed | msgspec.UnsetType = msgspec.UNSET
    back_emf_n_m_s: NonNegative | msgspec.UnsetType = msgspec.UNSET
    amplifier_lag_s: NonNegative | msgspec.UnsetType = msgspec.UNSET
    input_limit: Positive | msgspec.UnsetType = msgspec.UNSET
    gear_play_rad: NonNegative | msgspec.UnsetType = msgspec.UNSET
    gear_ratio: Signed | msgspec.UnsetType = msgspec.UNSET


class Accelerometer(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The accelerometer at the tip; `scale` is signed, `delay_s` the group delay of its filter."""

    scale: Signed = 1.0
    delay_s: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.0
    noise_std_m_s2: NonNegative = 0.5
    bias_m_s2: Signed = 0.0
    range_m_s2: Positive = 19.6


class Camera(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The camera at the tip; `scale_px_per_m` is signed."""

    mode: Literal["freerun", "triggered"] = "freerun"
    shutter: Literal["global", "rolling"] = "global"
    readout_s: NonNegative = 0.0
    frame_rate_hz: Annotated[float, Meta(gt=0.0, le=1000.0)] = 65.0
    exposure_s: NonNegative = 0.015
    scale_px_per_m: Signed = 800.0
    rotation_px_per_rad: Signed = 0.0
    noise_std_px: NonNegative = 0.05


class Timing(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The controller's cycle and the capture delay: reading of a visual sample minus mid-exposure."""

    cycle_s: Annotated[float, Meta(ge=0.0001, le=0.1)] = 0.001
    capture_delay_s: Annotated[float, Meta(ge=0.0, le=2.0)] = 0.074
    capture_delay_std_s: NonNegative = 0.0064


class Commissioned(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """How the file's parameters were identified on the rig, and how well.

    date: day of the recording. std: standard deviations, by the parameters' keys (arm.modes[0].frequency_hz), in their
    units.
    """

    date: str
    recording: str
    std: dict[str, NonNegative] = {}


class Model(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The whole model file. A key that is left out takes the default shown in its section's class."""

    arm: Arm = Arm()
    drive: Drive = Drive()
    accelerometer: Accelerometer = Accelerometer()
    camera: Camera = Camera()
    timing: Timing = Timing()
    effects: list[dict[str, EffectValue]] = []
    commissioned: Commissioned | msgspec.UnsetType = msgspec.UNSET

    @property
    def identified(self) -> bool:
        """Whether `stillarm commission` or `calibrate` made this file."""
        return self.commissioned is not msgspec.UNSET

    @classmethod
    def read(cls, path: str | Path) -> "Model":
        """Read a model file. Raises UserError in one line naming file, key, value and what is allowed."""
        return load_model(path)


def load_model(path: str | Path) -> Model:
    """Read a model file. Raises UserError in one line naming file, key, value and what is allowed."""
    return check_model(load_toml(path, Model), str(path))


def check_model(model: Model, name: str) -> Model:
    """Check what spans several keys; returns the model. `name` stands for the file in the message."""
    drive = model.drive
    if not drive.min_position_rad < drive.max_position_rad:
        raise UserError(
            f"{name}: drive.min_position_rad = {drive.min_position_rad}: "
            f"must lie below drive.max_position_rad = {drive.max_position_rad}"
        )
    if drive.kind != "velocity" and drive.inertia_kg_m2 is msgspec.UNSET:
        raise UserError(
            f'{name}: drive.inertia_kg_m2: needed where drive.kind = "{drive.kind}", and absent; give the inertia of '
            "the joint with its arm, kg m^2"
        )
    for key, value in (
        ("accelerometer.scale", model.accelerometer.scale),
        ("camera.scale_px_per_m", model.camera.scale_px_per_m),
    ):
        if abs(value) < _SMALLEST_SCALE:
            raise UserError(
                f"{name}: {key} = {value + 0.0:g}: a signed number of at least {_SMALLEST_SCALE:g} in size is needed; "
                "`stillarm calibrate` finds it"
            )
    if model.arm.modes[0].participation == 0.0:
        raise UserError(
            f"{name}: arm.modes[0].participation = 0: the joint could neither move nor damp the first mode; a "
            "signed number other than zero is needed, 1.14 for a uniform beam"
        )
    if model.camera.exposure_s * model.camera.frame_rate_hz > 1.0 + 1e-9:
        raise UserError(
            f"{name}: camera.exposure_s = {model.camera.exposure_s}: longer than a frame at "
            f"camera.frame_rate_hz = {model.camera.frame_rate_hz}; "
            f"at most {1.0 / model.camera.frame_rate_hz:.6f}"
        )
    check_effects(model.effects, name)
    return model


def length_of(model: Model, name: str) -> float:
    """Length of the arm in metres. Raises UserError when the model has none but a deflection is asked for."""
    if model.arm.length_m is None:
        raise UserError(
            f"{name}: arm.length_m: needed for a deflection and absent; "
            "measure it from joint to tip, or run `stillarm calibrate`"
        )
    return model.arm.length_m


def refuse_driven_effects(model: Model, name: str) -> None:
    """Raise UserError for an effect that only a joint has that a torque, a current or a voltage drives."""
    for index, effect in enumerate(model.effects):
        if effect.get("cause") in DRIVEN_CAUSES:
            raise UserError(
                f"{name}: effects[{index}].cause = {effect['cause']!r}: a cause of joints that a torque, a current or "
                "a voltage drives, which only `stillarm diagnose` of such a recording obeys; remove it"
            )
