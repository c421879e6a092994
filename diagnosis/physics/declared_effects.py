"""The effects that a model file already has, as values of the simulation's quantities.

A recording is held against its model as it is: an effect that the model has is no departure, and one that is found
again was there to another amount. Effects that are but another value of a key are folded in before
(stillarm.common.files.effects).
Lost frames, bursts, spikes and steps of a clock come by chance: no simulation foretells them, and they are found anew.
"""

from collections.abc import Callable, Collection, Iterator, Mapping
from functools import cache
from math import atan2, cos, hypot, isnan, pi, sin, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stillarm.common.causes import CAUSES, LAWS, Parameter
from stillarm.common.causes.declaration import Acts
from stillarm.common.files.effects import effect_of, filled_in
from stillarm.common.files.effects_check import EffectValue
from stillarm.common.files.model import Model
from stillarm.diagnosis.physics.space import Quantity

Array = NDArray[np.float64]

_QUANTITIES: dict[str, dict[str, str]] = {
    "coulomb_damping": {"force_per_mass_m_s2": "arm.coulomb_m_s2"},
    "quadratic_damping": {"coefficient_per_m": "arm.quadratic_per_m"},
    "cubic_stiffness": {"coefficient_per_m2": "arm.cubic_per_m2"},
    "payload_change": {
        "onset_s": "arm.onset_s",
        "frequency_ratio": "arm.frequency_ratio",
        "higher_modes_share": "arm.higher_modes_share",
    },
    "drive_deadband": {"deadband_rad_s": "drive.deadband_rad_s"},
    "gear_backlash": {"gap_rad": "drive.gap_rad"},
    "joint_friction": {"velocity_loss_rad_s": "drive.velocity_loss_rad_s"},
    "accelerometer_bias_drift": {"rate_m_s3": "accelerometer.rate_m_s3"},
    "accelerometer_sensitivity_drift": {"rate_per_s": "accelerometer.rate_per_s"},
    "gravity_leakage": {"gain_m_s2_per_rad": "accelerometer.gravity_m_s2_per_rad"},
    "tracking_drift": {"rate_px_per_s": "camera.rate_px_per_s"},
    "lens_distortion": {"coefficient_per_px2": "camera.lens_per_px2"},
    "camera_clock_skew": {"skew_ppm": "timing.skew_ppm"},
    "delay_drift": {"rate_s_per_s": "timing.delay_rate"},
    "stale_frame_buffer": {"onset_s": "timing.stale_onset_s", "frames": "timing.stale_frames"},
}
_WAVES = {"periodic_disturbance": "arm.periodic", "mains_hum": "accelerometer.hum"}
_HARMONICS = (
    ("periodic_disturbance", 1.0, "arm.periodic", "arm.periodic"),
    ("mains_hum", 1.0, "accelerometer.hum", "accelerometer.hum"),
    ("mains_hum", 3.0, "accelerometer.hum", "accelerometer.hum_third"),
)
"""Of waves: order, and how the quantities of its frequency, and of its sine and cosine parts, begin."""
_OWN_WAY = {"stiffness_drift", *_WAVES}

_FITTED: set[Acts] = {"force", "friction", "frequency", "command", "sensitivity", "reading", "image"}
"""Sites whose laws a simulation of a recording obeys whatever the cause."""


def quantity_of(cause: str, parameter: str) -> str:
    """Where a parameter of a cause stands in the vector: at a name of its own, unless it is a key's or an older one."""
    return LAWS[cause].key or _QUANTITIES.get(cause, {}).get(parameter, f"{cause}.{parameter}")


def own_quantities() -> list[Quantity]:
    """Of causes that stand in the vector at names of their own, as their declarations have them."""
    return [_own_quantity(cause, one) for cause, one in _own_numbers(_FITTED)]


def own_names(*acts: Acts) -> frozenset[str]:
    """The names of their own at which the numbers of causes that act at some sites stand in the vector."""
    return frozenset(quantity_of(cause, one.name) for cause, one in _own_numbers(acts))


def _own_numbers(acts: Collection[Acts]) -> Iterator[tuple[str, Parameter]]:
    """The numbers that stand at names of their own, each with its cause's identifier."""
    for cause in LAWS.values():
        if cause.acts in acts and cause.identifier not in _QUANTITIES.keys() | _OWN_WAY:
            for one in cause.numbers:
                yield cause.identifier, one


def _own_quantity(cause: str, one: Parameter) -> Quantity:
    low, high = one.typical
    if not isnan(one.neutral):
        return Quantity(quantity_of(cause, one.name), one.neutral, one.lowest, one.highest, 1e-3 * low)
    start = one.default if one.default is not None else sqrt(low * high)
    return Quantity(
        quantity_of(cause, one.name), float(start), one.lowest, one.highest, 1e-4 * (abs(float(start)) or 1.0)
    )


def declared_quantities(model: Model) -> dict[str, float]:
    """Start values by quantity, for the effects of a model whose foldable ones have been folded in."""
    found: dict[str, float] = {}
    for identifier, cause in CAUSES.items():
        effect = effect_of(model, identifier)
        if (
            effect is not None
            and identifier not in _OWN_WAY
            and (identifier in _QUANTITIES or cause.acts in _FITTED)
        ):
            found |= {quantity_of(identifier, one.name): float(effect[one.name]) for one in cause.numbers}
    drift = effect_of(model, "stiffness_drift")
    if drift is not None:
        found["arm.frequency_rate_per_s"] = drift["frequency_rate_hz_per_s"] / model.arm.modes[0].frequency_hz
        found["arm.higher_modes_share"] = drift["higher_modes_share"]
    for wavy, prefix in _WAVES.items():
        wave = effect_of(model, wavy)
        if wave is not None:
            found[f"{prefix}_hz"] = wave["frequency_hz"]
            amplitude = wave["amplitude_m_s2"]
            found[f"{prefix}_sin"] = amplitude * cos(wave["phase_rad"])
            found[f"{prefix}_cos"] = amplitude * sin(wave["phase_rad"])
    return found


@cache
def _fitted_laws() -> tuple[tuple[str, tuple[tuple[str, str, float], ...]], ...]:
    """The laws whose numbers are quantities, each with its numbers' names, quantities and neutral values."""
    return tuple(
        (
            identifier,
            tuple((one.name, quantity_of(identifier, one.name), one.neutral) for one in cause.numbers),
        )
        for identifier, cause in LAWS.items()
        if cause.acts in _FITTED and identifier not in _OWN_WAY
    )


def effects_in(vector: Array, place: Mapping[str, int]) -> list[tuple[str, dict[str, float]]]:
    """The effects that a vector says change anything by a law that is fitted, each with its values by name.

    place: of each quantity in the vector.
    """
    found = []
    for identifier, numbers in _fitted_laws():
        # most are idle, and this is asked for every prediction
        for _, quantity, neutral in numbers:
            if vector[place[quantity]] == neutral:
                break
        else:
            found.append(
                (identifier, {name: float(vector[place[quantity]]) for name, quantity, _ in numbers})
            )
    derived = []
    relative = float(vector[place["arm.frequency_rate_per_s"]])
    rate = {"frequency_rate_hz_per_s": relative * float(vector[place["modes.0.frequency_hz"]])}
    derived.append(
        ("stiffness_drift", rate | {"higher_modes_share": float(vector[place["arm.higher_modes_share"]])})
    )
    for cause, wave in waves_of(lambda name: float(vector[place[name]])):
        if cause == "mains_hum":
            # its law counts time from its onset: while that is sought, the wave stays where it is
            wave["phase_rad"] += (
                2.0 * pi * wave["frequency_hz"] * float(vector[place["accelerometer.begin_s"]])
            )
        derived.append((cause, wave))
    return [*found, *((cause, values) for cause, values in derived if not LAWS[cause].is_idle(values))]


def waves_of(value: Callable[[str], float]) -> list[tuple[str, dict[str, float]]]:
    """The waves that quantities say, idle ones too, each as an effect's values; a hum's third harmonic is a hum of its
    own. Phases are of the recording's time. value: of a quantity."""
    found = []
    for cause, order, prefix, parts in _HARMONICS:
        sine, cosine = value(f"{parts}_sin"), value(f"{parts}_cos")
        wave = {
            "frequency_hz": order * value(f"{prefix}_hz"),
            "amplitude_m_s2": hypot(sine, cosine),
            "phase_rad": atan2(cosine, sine),
        }
        found.append((cause, wave))
    return found


def waves_to_refit(model: Model) -> list[str]:
    """Quantities of waves whose phase is another in each recording: the baseline refits them."""
    return [
        f"{prefix}_{part}"
        for cause, prefix in _WAVES.items()
        if effect_of(model, cause) is not None
        for part in ("sin", "cos")
    ]


def is_behind_encoder(model: Model) -> bool:
    """Whether the model has a play behind the joint's encoder."""
    play = effect_of(model, "gear_backlash")
    return bool(play and play["behind_encoder"])


def with_found(
    effects: list[dict[str, EffectValue]], found: list[dict[str, EffectValue]]
) -> list[dict[str, EffectValue]]:
    """A model's effects with those found: what is found of a cause that the model had is its new amount."""
    causes = {one["cause"] for one in found}
    return [*(one for one in effects if one["cause"] not in causes), *found]


def laws_at(effects: list[tuple[str, dict[str, float]]], acts: Acts) -> list[Callable[..., Any]]:
    """The laws of effects that act at a site, with their own numbers."""
    found = [(LAWS[cause], values) for cause, values in effects if LAWS[cause].acts == acts]
    return [filled_in(cause.law, cause.arguments(values)) for cause, values in found if cause.law]
