"""Effects of a model file: checked against the catalogue, folded into the model where they are but another value."""

import difflib
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import msgspec

from common.causes import CAUSES, Cause, Parameter
from common.causes.declaration import Acts
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
                f"{place}.cause = {identifier!r}: no such cause; the nearest is {near!r}, "
                "and `stillarm causes` lists all"
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


def acting(model: "Model") -> list[tuple[str, Values]]:
    """(cause, parameters) of every effect that changes anything, in the catalogue's order, then the file's."""
    return [
        (identifier, values)
        for identifier, cause in CAUSES.items()
        for values in effects_of(model, identifier)
        if not cause.is_idle(values)
    ]


def laws_at(model: "Model", acts: Acts) -> list[Callable[..., Any]]:
    """The laws of the model's effects that act at a site, each with its own numbers filled in: what the site gives ->
    what the law returns (common.causes.declaration)."""
    acting_there = [(CAUSES[name], values) for name, values in acting(model) if CAUSES[name].acts == acts]
    return [filled_in(cause.law, cause.arguments(values)) for cause, values in acting_there if cause.law]


def filled_in(law: Callable[..., Any], own: tuple[float, ...]) -> Callable[..., Any]:
    """A law with its own numbers, which come last, in their places."""
    return lambda *given: law(*given, *own)


def declared(model: "Model") -> "Model":
    """The model with those effects folded in that are but another value of a key; the other effects stay.

    For controller, replay and simulation alike, so that all of them read such an effect in one way.
    """
    remaining = []
    for effect in model.effects:
        key = CAUSES[str(effect["cause"])].key
        if not key:
            remaining.append(effect)
        else:
            model = _fold(model, key, {name: value for name, value in effect.items() if name != "cause"})
    return msgspec.structs.replace(model, effects=remaining)


def not_used_by_controller(model: "Model") -> str | None:
    """One line that names the effects which no estimator makes use of; None where there are none."""
    causes = dict.fromkeys(str(effect["cause"]) for effect in declared(model).effects)
    causes.pop(_OBEYED_BY_CONTROLLER, None)
    if not causes:
        return None
    return f"the controller makes no use of these effects of its model: {', '.join(causes)}"


def _fold(model: "Model", key: str, values: Values) -> "Model":
    """The model with the values in a key's place, or at the end of a list of them."""
    section, name = key.split(".")
    old = getattr(model, section)
    if name in values:
        changed = msgspec.structs.replace(old, **{name: values[name]})
    else:
        listed = getattr(old, name)
        changed = msgspec.structs.replace(
            old, **{name: [*listed, msgspec.structs.replace(listed[0], **values)]}
        )
    return msgspec.structs.replace(model, **{section: changed})


_OBEYED_BY_CONTROLLER = "gear_backlash"
FOLDED_CAUSES = frozenset(cause.identifier for cause in CAUSES.values() if cause.key)
"""Those that are but another value of a key."""
