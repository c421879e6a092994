"""The catalogue, the checks on [[effects]], and folding into the model."""

from math import isnan
from pathlib import Path
from typing import Any

import pytest

from stillarm.common.causes import CAUSES, Parameter
from stillarm.common.files.effects import (
    FOLDED_CAUSES,
    declared,
    effect_of,
    effects_of,
    not_used_by_controller,
)
from stillarm.common.files.effects_check import check_effects
from stillarm.common.files.model import Drive, Model, load_model
from stillarm.common.user_error import UserError

CUBIC = {"cause": "cubic_stiffness", "coefficient_per_m2": 100.0}


def smallest(parameter: Parameter) -> Any:
    """A value that is allowed."""
    if parameter.kind == "truth":
        return True
    return parameter.choices[0] if parameter.kind == "text" else parameter.lowest


def test_the_catalogue_is_in_order_of_place_and_name() -> None:
    places = ["arm", "drive", "accelerometer", "camera", "timing"]
    order = [(places.index(cause.place), name) for name, cause in CAUSES.items()]
    assert order == sorted(order)
    assert {cause.place for cause in CAUSES.values()} == set(places)


@pytest.mark.parametrize("identifier", CAUSES)
def test_bounds_and_typical_sizes_agree(identifier: str) -> None:
    """Typical sizes lie within the bounds, to either side where signed; what is neutral is allowed."""
    for parameter in CAUSES[identifier].parameters:
        if parameter.kind in {"truth", "text"} or parameter.name == "onset_s":
            continue
        low, high = parameter.typical
        base = 0.0 if isnan(parameter.neutral) else parameter.neutral
        assert 0.0 <= low < high
        for sign in (1.0, -1.0) if parameter.signed else (1.0,):
            assert parameter.lowest <= base + sign * low <= parameter.highest
            assert parameter.lowest <= base + sign * high <= parameter.highest


@pytest.mark.parametrize("identifier", CAUSES)
def test_every_parameter_is_asked_for_and_bounded_in_one_line(identifier: str) -> None:
    cause = CAUSES[identifier]
    whole = {"cause": identifier} | {p.name: smallest(p) for p in cause.parameters}
    check_effects([whole], "m.toml")
    for parameter in cause.parameters:
        name = f"^m\\.toml: effects\\[0\\]\\.{parameter.name}"
        wrong: list[Any] = ["no such"]
        if parameter.kind in {"number", "whole"}:
            wrong += [parameter.lowest - 1e-6 - abs(parameter.lowest), 2.0 * parameter.highest + 1.0, True]
            wrong += [0.5] if parameter.kind == "whole" else []
        else:
            wrong += [1.0]
        for value in wrong:
            with pytest.raises(UserError, match=name + " = ") as refused:
                check_effects([whole | {parameter.name: value}], "m.toml")
            assert "\n" not in str(refused.value)
        without = {key: value for key, value in whole.items() if key != parameter.name}
        if parameter.default is None:
            with pytest.raises(UserError, match=name + f": needed by {identifier} and missing; add "):
                check_effects([without], "m.toml")
        else:
            check_effects([without], "m.toml")
            filled = effects_of(Model(effects=[without]), identifier)[0]
            assert filled[parameter.name] == parameter.default
    if not cause.repeatable:
        with pytest.raises(
            UserError, match=r"effects\[1\]\.cause = .*second time, after effects\[0\]; remove one"
        ):
            check_effects([whole, whole], "m.toml")
    else:
        check_effects([whole, whole], "m.toml")


@pytest.mark.parametrize(
    ("effect", "told"),
    [
        (
            {"cause": "cubic_stifness"},
            "effects[0].cause = 'cubic_stifness': no such cause; the nearest is 'cubic_",
        ),
        ({}, "effects[0].cause: a cause's name is needed"),
        (
            CUBIC | {"coefficient_per_m": 1.0},
            "effects[0].coefficient_per_m = 1.0: cubic_stiffness has no such",
        ),
    ],
)
def test_a_model_file_with_a_wrong_effect_is_refused(
    tmp_path: Path, effect: dict[str, Any], told: str
) -> None:
    path = tmp_path / "m.toml"
    path.write_text("[[effects]]\n" + "\n".join(f"{k} = {v!r}" for k, v in effect.items()))
    with pytest.raises(UserError) as refused:
        load_model(path)
    assert str(refused.value).startswith(f"{path}: {told}")
    assert "\n" not in str(refused.value)


def test_what_is_but_another_value_is_folded_and_the_rest_stays() -> None:
    model = Model(
        effects=[
            {"cause": "drive_dead_time", "dead_time_s": 0.03},
            CUBIC,
            {
                "cause": "second_bending_mode",
                "frequency_hz": 15.0,
                "damping_ratio": 0.02,
                "participation": -0.2,
            },
            {"cause": "accelerometer_clipping", "range_m_s2": 2.0},
            {"cause": "accelerometer_lag", "delay_s": 0.01},
            {"cause": "camera_tilt_coupling", "rotation_px_per_rad": -80.0},
            {"cause": "drive_lag", "bandwidth_hz": 7.0},
            {"cause": "drive_saturation", "max_velocity_rad_s": 0.1},
        ]
    )
    folded = declared(model)
    assert folded.effects == [CUBIC]
    assert folded.drive == Drive(dead_time_s=0.03, bandwidth_hz=7.0, max_velocity_rad_s=0.1)
    assert (folded.accelerometer.range_m_s2, folded.accelerometer.delay_s) == (2.0, 0.01)
    assert folded.camera.rotation_px_per_rad == -80.0
    assert [mode.frequency_hz for mode in folded.arm.modes] == [2.6, 15.0]
    assert declared(folded) == folded
    assert {str(effect["cause"]) for effect in model.effects} - {"cubic_stiffness"} == FOLDED_CAUSES
    assert declared(Model()) == Model()


def test_the_controller_says_what_it_makes_no_use_of() -> None:
    unused = not_used_by_controller(Model(effects=[CUBIC, {"cause": "drive_lag", "bandwidth_hz": 7.0}]))
    assert unused is not None and unused.endswith(": cubic_stiffness")
    assert not_used_by_controller(Model(effects=[{"cause": "drive_lag", "bandwidth_hz": 7.0}])) is None
    assert not_used_by_controller(Model(effects=[{"cause": "gear_backlash", "gap_rad": 0.01}])) is None
    assert effect_of(Model(), "cubic_stiffness") is None
