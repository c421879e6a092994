"""The model file with what was fitted and what was found: simulate, replay and the demo run it."""

from typing import Any

import msgspec
import tomli_w

from stillarm.common.causes import CAUSES
from stillarm.common.files.effects_check import EffectValue
from stillarm.common.files.model import Model
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.physics.declared_effects import waves_of
from stillarm.diagnosis.search.candidates import Candidate
from stillarm.diagnosis.sensors.laws import OF_STAMPS


def effects_of(one: Candidate, final: Fit) -> list[dict[str, EffectValue]]:
    """A finding as entries of [[effects]]: a wave's further harmonics are waves of their own."""
    further = [wave for wave in _waves(one, final)[1:] if wave["amplitude_m_s2"] > 0.0]
    others: list[dict[str, EffectValue]] = [{"cause": one.cause, **wave} for wave in further]
    return [effect_of(one, final), *others]


def _waves(one: Candidate, final: Fit) -> list[dict[str, float]]:
    return [wave for cause, wave in waves_of(final.value) if cause == one.cause]


def effect_of(one: Candidate, final: Fit) -> dict[str, EffectValue]:
    """A finding as an entry of [[effects]], its values those of the last fit."""
    values = one.values
    if one.law is None and one.parameters_of is not None:
        values = one.parameters_of(final)
    effect: dict[str, EffectValue] = {"cause": one.cause}
    for parameter in CAUSES[one.cause].parameters:
        if parameter.name not in values:
            continue
        value = values[parameter.name][0]
        if parameter.kind == "whole":
            effect[parameter.name] = round(value)
        else:
            effect[parameter.name] = float(min(max(value, parameter.lowest), parameter.highest))
    for wave in _waves(one, final)[:1]:
        effect["phase_rad"] = wave["phase_rad"]
    if one.cause == "gear_backlash":
        effect["behind_encoder"] = final.world.behind_encoder
    if one.cause == "clock_step" and one.note:
        effect["clock"] = "camera" if one.note == OF_STAMPS else "all"
    return effect


def baseline_changes(model: Model, final: Fit) -> dict[str, dict[str, float]]:
    """Model-file parameters that were simply off: by more than three deviations and a thousandth."""
    world = final.world
    has = world.channels
    pairs: list[tuple[str, float, str]] = []
    for i, mode in enumerate(model.arm.modes):
        key = f"arm.modes[{i}]"
        pairs += [
            (f"{key}.frequency_hz", mode.frequency_hz, f"modes.{i}.frequency_hz"),
            (f"{key}.damping_ratio", mode.damping_ratio, f"modes.{i}.damping_ratio"),
            (f"{key}.participation", mode.participation, f"modes.{i}.participation"),
        ]
    if "acceleration" in has:
        pairs.append(("accelerometer.bias_m_s2", model.accelerometer.bias_m_s2, "accelerometer.bias_m_s2"))
    if "displacement" in has:
        pairs.append(("camera.scale_px_per_m", model.camera.scale_px_per_m, "camera.scale_px_per_m"))
        pairs.append(("timing.capture_delay_s", model.timing.capture_delay_s, "timing.capture_delay_s"))
    found: dict[str, dict[str, float]] = {}
    for key, configured, name in pairs:
        if name not in final.free:
            continue
        fitted, std = final.value(name), final.std[name]
        if abs(fitted - configured) > max(3.0 * std, 1e-3 * abs(configured)):
            found[key] = {"configured": configured, "fitted": fitted, "std": std}
    levels = [
        ("accelerometer.noise_std_m_s2", model.accelerometer.noise_std_m_s2, final.channel("acceleration"))
    ]
    if world.frame_clock.counted:
        levels.append(("camera.noise_std_px", model.camera.noise_std_px, final.channel("displacement")))
    for key, configured, channel in levels:
        if channel is None:
            continue
        fitted = channel.sigma
        count = max(len(channel.measured), 2)
        if abs(fitted - configured) > 0.1 * max(configured, 1e-9):
            found[key] = {"configured": configured, "fitted": fitted, "std": fitted / (2.0 * count) ** 0.5}
    return found


def model_text(model: Model) -> str:
    """A model file's text."""
    return tomli_w.dumps(_present(msgspec.to_builtins(model)))


def _present(value: Any) -> Any:
    """Without what is None: TOML has no such value."""
    if isinstance(value, dict):
        return {key: _present(one) for key, one in value.items() if one is not None}
    if isinstance(value, list):
        return [_present(one) for one in value]
    return value
