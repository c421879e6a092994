"""The catalogue of causes: what can make a rig depart from its model, one file each, as [[effects]] of a model file.

Here belongs all that is said of a cause in any part of the program; how its effects are checked and folded into a model
is stillarm.common.files.effects, how a search looks for it stillarm.diagnosis.forms.causes. The package finds a new
file by itself; docs/causes.md comes from `stillarm causes --markdown`. Begin to read at declaration.py.
"""

from importlib import import_module
from pkgutil import iter_modules

from stillarm.common.causes.declaration import Cause, Parameter, Place, Value
from stillarm.common.causes.rivals import RIVALS

_NO_CAUSE = ("declaration", "driven", "page", "rivals")
_PLACES: tuple[Place, ...] = ("arm", "drive", "accelerometer", "camera", "timing")


def _found() -> dict[str, Cause]:
    names = [one.name for one in iter_modules(__path__) if one.name not in _NO_CAUSE]
    causes: list[Cause] = [import_module(f"{__name__}.{name}").CAUSE for name in names]
    in_order = sorted(causes, key=lambda cause: (_PLACES.index(cause.place), cause.identifier))
    return {cause.identifier: cause for cause in in_order}


CAUSES: dict[str, Cause] = _found()
"""All of them by identifier: by place, then by name."""

LAWS: dict[str, Cause] = CAUSES | RIVALS
"""What a simulation obeys: the causes, and what is held against them without a name."""


def experiment_between(cause: str, other: str) -> str | None:
    """What to record to tell two causes apart; None where neither declaration names the other."""
    return CAUSES[cause].confused_with.get(other) or CAUSES[other].confused_with.get(cause)


__all__ = [
    "CAUSES",
    "LAWS",
    "RIVALS",
    "Cause",
    "Parameter",
    "Place",
    "Value",
    "clock_step",
    "declaration",
    "driven",
    "experiment_between",
    "rivals",
]
