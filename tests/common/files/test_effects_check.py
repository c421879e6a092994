"""A wrong effect in a model file is refused in one line."""

from pathlib import Path
from typing import Any

import pytest

from stillarm.common.causes import CAUSES, Parameter
from stillarm.common.files.effects import (
    effects_of,
)
from stillarm.common.files.effects_check import check_effects
from stillarm.common.files.model import Model, load_model
from stillarm.common.user_error import UserError

CUBIC = {"cause": "cubic_stiffness", "coefficient_per_m2": 100.0}


def smallest(parameter: Parameter) -> Any:
    """A value that is allowed."""
    if parameter.kind == "truth":
        return True
    return parameter.choices[0] if parameter.kind == "text" else parameter.lowest


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
