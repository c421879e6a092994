"""Effects of a model file against the catalogue of causes: each is there, with its own parameters, within bounds."""

import difflib
from collections.abc import Mapping, Sequence

from stillarm.common.causes import CAUSES, Cause, Parameter
from stillarm.common.causes.driven import DRIVEN_CAUSES, DrivenCause
from stillarm.common.user_error import UserError

EffectValue = str | float | int | bool
"""A value of an [[effects]] table."""


def check_effects(effects: Sequence[Mapping[str, EffectValue]], name: str) -> None:
    """Raise UserError, one line, for the first effect that the catalogue does not allow; `name` stands for the file."""
    seen: dict[str, int] = {}
    for index, effect in enumerate(effects):
        place = f"{name}: effects[{index}]"
        identifier = effect.get("cause")
        if not isinstance(identifier, str):
            raise UserError(f'{place}.cause: a cause\'s name is needed, such as "cubic_stiffness"')
        cause = CAUSES.get(identifier) or DRIVEN_CAUSES.get(identifier)
        if cause is None:
            near = difflib.get_close_matches(identifier, [*CAUSES, *DRIVEN_CAUSES], n=1, cutoff=0.0)[0]
            raise UserError(
                f"{place}.cause = {identifier!r}: no such cause; the nearest is {near!r}, "
                "and `stillarm causes` lists all"
            )
        if identifier in seen and not cause.repeatable:
            raise UserError(
                f"{place}.cause = {identifier!r}: named a second time, after effects[{seen[identifier]}]; remove one"
            )
        seen[identifier] = index
        _check_parameters(effect, cause, place)


def _check_parameters(effect: Mapping[str, EffectValue], cause: Cause | DrivenCause, place: str) -> None:
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
