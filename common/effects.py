"""Effects of a model file: checked against the catalogue, folded into the model where they are but another value."""

import difflib
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import msgspec

from common.causes import CAUSES, Cause, Parameter
from common.user_error import UserError

if TYPE_CHECKING:
    from common.model import EffectValue, Model

Values = dict[str, Any]
"""A cause's parameters by name, the optional ones filled in."""


def check_effects(effects: Sequence[Mapping[str, "EffectValue"]], name: str) -> None:
    """Raise UserError, one line, for the first effect that the catalogue does not allow; `name` stands for the file."""
    seen: dict[str, int] = {}
    for index, effect in enumerate(effects):
        place = f"{name}: effects[{index}]"
        identifier = effect.get("cause")
        if not isinstance(identifier, str):
            raise UserError(f'{place}.cause: a cause\'s name is needed, such as "cubic_stiffness"')
        cause = CAUSES.get(identifier)
        if cause is None:
            near = difflib.get_close_matches(identifier, CAUSES, n=1, cutoff=0.0)[0]
            raise UserError(
                f"{place}.cause = {identifier!r}: no such cause; the nearest is {near!r}, and docs/causes.md lists all"
            )
        if identifier in seen and not cause.repeatable:
            raise UserError(
                f"{place}.cause = {identifier!r}: named a second time, after effects[{seen[identifier]}]; remove one"
            )
        seen[identifier] = index
        _check_parameters(effect, cause, place)


def _check_parameters(effect: Mapping[str, "EffectValue"], cause: Cause, place: str) -> None:
    known = {parameter.name: parameter for parameter in cause.parameters}
    for key, value in effect.items():
        if key == "cause":
            continue
        if key not in known:
            raise UserError(
                f"{place}.{key} = {value!r}: {cause.identifier} has no such parameter; it takes {', '.join(known)}"
            )
        if not _fits(value, known[key]):
            raise UserError(f"{place}.{key} = {value!r}: {_allowed(known[key])} is needed")
    for parameter in cause.parameters:
        if parameter.default is None and parameter.name not in effect:
            raise UserError(
                f"{place}.{parameter.name}: needed by {cause.identifier} and missing; add {_allowed(parameter)}"
            )


def _fits(value: object, parameter: Parameter) -> bool:
    if parameter.kind == "truth":
        return isinstance(value, bool)
    if parameter.kind == "text":
        return value in parameter.choices
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    whole = parameter.kind != "whole" or value == int(value)
    return parameter.lowest <= value <= parameter.highest and whole


def _allowed(parameter: Parameter) -> str:
    if parameter.kind == "truth":
        return "true or false"
    if parameter.kind == "text":
        return " or ".join(f'"{choice}"' for choice in parameter.choices)
    kind = "a whole number" if parameter.kind == "whole" else "a number"
    return f"{kind} from {parameter.lowest:g} to {parameter.highest:g} ({parameter.unit})"


def effects_of(model: "Model", identifier: str) -> list[Values]:
    """The parameters of every effect of a cause in a checked model, in the file's order."""
    defaults = {p.name: p.default for p in CAUSES[identifier].parameters if p.default is not None}
    return [defaults | effect for effect in model.effects if effect.get("cause") == identifier]


def effect_of(model: "Model", identifier: str) -> Values | None:
    """The parameters of a cause that a model holds at most once; None where it does not."""
    return next(iter(effects_of(model, identifier)), None)


def declared(model: "Model") -> "Model":
    """The model with those effects folded in that are but another value of a key; the other effects stay.

    For controller, replay and simulation alike, so that all of them read such an effect in one way.
    """
    remaining = []
    for effect in model.effects:
        fold = _FOLDS.get(str(effect["cause"]))
        if fold is None:
            remaining.append(effect)
        else:
            model = fold(model, {key: value for key, value in effect.items() if key != "cause"})
    return msgspec.structs.replace(model, effects=remaining)


def not_used_by_controller(model: "Model") -> str | None:
    """One line that names the effects which no estimator makes use of; None where there are none."""
    causes = dict.fromkeys(str(effect["cause"]) for effect in declared(model).effects)
    causes.pop(_OBEYED_BY_CONTROLLER, None)
    if not causes:
        return None
    return f"the controller makes no use of these effects of its model: {', '.join(causes)}"


def _second_bending_mode(model: "Model", values: Values) -> "Model":
    mode = msgspec.structs.replace(model.arm.modes[0], **values)
    return msgspec.structs.replace(
        model, arm=msgspec.structs.replace(model.arm, modes=[*model.arm.modes, mode])
    )


def _replace_in(section: str) -> Callable[["Model", Values], "Model"]:
    """A fold for a cause whose parameter has the name of the key that it replaces."""

    def fold(model: "Model", values: Values) -> "Model":
        changed = msgspec.structs.replace(getattr(model, section), **values)
        return msgspec.structs.replace(model, **{section: changed})

    return fold


_FOLDS: dict[str, Callable[["Model", Values], "Model"]] = {
    "second_bending_mode": _second_bending_mode,
    "drive_dead_time": _replace_in("drive"),
    "drive_lag": _replace_in("drive"),
    "drive_saturation": _replace_in("drive"),
    "accelerometer_clipping": _replace_in("accelerometer"),
    "accelerometer_lag": _replace_in("accelerometer"),
    "camera_tilt_coupling": _replace_in("camera"),
}
_OBEYED_BY_CONTROLLER = "gear_backlash"
FOLDED_CAUSES = frozenset(_FOLDS)
"""Those that are but another value of a key."""
