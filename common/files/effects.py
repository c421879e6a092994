"""Effects of a checked model: their parameters and laws. An effect that is only another value of a key is folded into
the model."""

from collections.abc import Callable
from typing import Any

import msgspec

from stillarm.common.causes import CAUSES
from stillarm.common.causes.declaration import Acts
from stillarm.common.files.model import Model

Values = dict[str, Any]
"""A cause's parameters by name, the optional ones filled in."""


def effects_of(model: Model, identifier: str) -> list[Values]:
    """The parameters of every effect of a cause in a checked model, in the file's order."""
    defaults = {p.name: p.default for p in CAUSES[identifier].parameters if p.default is not None}
    return [defaults | effect for effect in model.effects if effect.get("cause") == identifier]


def effect_of(model: Model, identifier: str) -> Values | None:
    """The parameters of a cause that a model holds at most once; None where it does not."""
    return next(iter(effects_of(model, identifier)), None)


def acting(model: Model) -> list[tuple[str, Values]]:
    """(cause, parameters) of every effect that changes anything, in the catalogue's order, then the file's."""
    return [
        (identifier, values)
        for identifier, cause in CAUSES.items()
        for values in effects_of(model, identifier)
        if not cause.is_idle(values)
    ]


def laws_at(model: Model, acts: Acts) -> list[Callable[..., Any]]:
    """The laws of the model's effects that act at a site, each with its own numbers filled in: what the site gives ->
    what the law returns (stillarm.common.causes.declaration)."""
    acting_there = [(CAUSES[name], values) for name, values in acting(model) if CAUSES[name].acts == acts]
    return [filled_in(cause.law, cause.arguments(values)) for cause, values in acting_there if cause.law]


def filled_in(law: Callable[..., Any], own: tuple[float, ...]) -> Callable[..., Any]:
    """A law with its own numbers, which come last, in their places."""
    return lambda *given: law(*given, *own)


def declared(model: Model) -> Model:
    """The model with those effects folded in that are only another value of a key; the other effects stay.

    For controller, replay and simulation alike, so that all of them read such an effect in one way.
    """
    remaining = []
    for effect in model.effects:
        cause = CAUSES.get(str(effect["cause"]))  # None: of a driven joint, which only its diagnosis obeys
        key = cause.key if cause else ""
        if not key:
            remaining.append(effect)
        else:
            model = _fold(model, key, {name: value for name, value in effect.items() if name != "cause"})
    return msgspec.structs.replace(model, effects=remaining)


def not_used_by_controller(model: Model) -> str | None:
    """One line that names the effects which no estimator makes use of; None where there are none."""
    causes = dict.fromkeys(str(effect["cause"]) for effect in declared(model).effects)
    causes.pop(_OBEYED_BY_CONTROLLER, None)
    if not causes:
        return None
    return f"the controller makes no use of these effects of its model: {', '.join(causes)}"


def _fold(model: Model, key: str, values: Values) -> Model:
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
