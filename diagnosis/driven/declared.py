"""What a model file declares of a driven joint's causes, and what a diagnosis adds to it: extended.toml, both ways.

Most stand under [[effects]] with the simulation's own numbers. Two are another value of a key of the model:
the amplifier's limit (drive.input_limit) and play (drive.gear_play_rad). accelerometer.delay_s is read as a lag.
"""

from collections.abc import Iterable, Mapping

import msgspec
import numpy as np

from stillarm.common.causes.driven import DRIVEN_CAUSES
from stillarm.common.files.effects_check import EffectValue
from stillarm.common.files.model import Model
from stillarm.diagnosis.driven.decision.decide import DrivenFinding
from stillarm.diagnosis.driven.recording.own import base_of, numbers_in, recording_of
from stillarm.diagnosis.driven.recording.signals import Driven

_ARM = {
    "coulomb_damping": ("force_per_mass_m_s2", "arm_coulomb"),
    "cubic_stiffness": ("coefficient_per_m2", "arm_cubic_over_w2"),
}
"""Causes of the arm that a driven joint's arm has as well: the parameter and the simulation's number."""
_KEYS = {"drive_saturation": "limit", "gear_backlash": "gap"}
NONE_OF_THEM = -1  # number of no recording: only what holds in all of them
Effect = dict[str, EffectValue]


def declared_numbers(model: Model, driven: Driven) -> dict[str, float]:
    """The simulation's numbers that the model's effects and keys state, by name. A limit that a model of the whole
    joint states is in the drive's unit: of no use where the recording's is unknown."""
    numbers: dict[str, float] = {}
    for effect in model.effects:
        cause = str(effect["cause"])
        if cause in DRIVEN_CAUSES:
            numbers |= DRIVEN_CAUSES[cause].numbers_of(effect)
            if cause == "channel_delay" and not effect.get("channel"):
                numbers["late"] = 1.0
        elif cause in _ARM:
            parameter, number = _ARM[cause]
            numbers[number] = float(effect[parameter])
    same_unit = driven.drive_stated or model.drive.kind == "velocity"
    if same_unit and not isinstance(model.drive.input_limit, msgspec.UnsetType):
        numbers["limit"] = model.drive.input_limit
    if not isinstance(model.drive.gear_play_rad, msgspec.UnsetType) and model.drive.gear_play_rad > 0.0:
        numbers["gap"] = model.drive.gear_play_rad
    if model.accelerometer.delay_s > 0.0:
        numbers.setdefault("lag acceleration_m_s2", model.accelerometer.delay_s)
    return numbers


def with_findings(
    model: Model,
    findings: Iterable[DrivenFinding],
    numbers: Mapping[str, float],
    recording: int = NONE_OF_THEM,
) -> Model:
    """The model with what was found in all recordings, and in one. numbers: of the final fit."""
    here = numbers_in(numbers, recording)
    findings = [one for one in findings if recording_of(one.form.numbers[0]) in (None, recording)]
    own: dict[tuple[str, str], dict[str, float]] = {}
    for one in findings:
        names = {base_of(name) for name in one.form.numbers}
        channel = _channel_of(names) or (one.channel if one.own else "")
        values = {name: here[name] for name in names if name in here}
        values |= {f"{name} {channel}": value for name, value in one.own.items()}
        own.setdefault((one.form.cause, channel), {}).update(values)
    for (cause, channel), values in own.items():
        if cause in _KEYS:
            model = _with_key(model, cause, values[_KEYS[cause]])
        else:
            model = _with_effect(model, _effect(cause, channel, values, here))
    return model


def _channel_of(names: Iterable[str]) -> str:
    """The channel whose number is among them; empty where none is."""
    return next((name.partition(" ")[2] for name in names if " " in name), "")


def _effect(cause: str, channel: str, values: dict[str, float], here: Mapping[str, float]) -> Effect:
    if cause not in _ARM:
        return DRIVEN_CAUSES[cause].effect_of(values, channel)
    parameter, number = _ARM[cause]
    w = float(np.exp(here["log_w_1"]))
    value = values["arm_cubic"] / w**2 if number == "arm_cubic_over_w2" else values[number]
    return {"cause": cause, parameter: float(value)}


def _with_effect(model: Model, effect: Effect) -> Model:
    """With the effect in place of one of its cause and channel."""

    def same(other: Mapping[str, EffectValue]) -> bool:
        return other["cause"] == effect["cause"] and other.get("channel") == effect.get("channel")

    before = [dict(one) for one in model.effects if same(one)]
    merged = {**(before[0] if before else {}), **effect}
    return msgspec.structs.replace(model, effects=[*(one for one in model.effects if not same(one)), merged])


def _with_key(model: Model, cause: str, value: float) -> Model:
    replace = msgspec.structs.replace
    if cause == "drive_saturation":
        return replace(model, drive=replace(model.drive, input_limit=float(value)))
    return replace(model, drive=replace(model.drive, gear_play_rad=float(value)))
