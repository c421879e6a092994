"""All causes that change a mean, by identifier: searched as their file in causes/ says, else as their declaration does.

Laws of noise and timing, which change none, are in laws.py.
"""

from importlib import import_module
from pkgutil import iter_modules

from stillarm.common.causes import CAUSES as DECLARED
from stillarm.diagnosis import causes
from stillarm.diagnosis.cause import Cause
from stillarm.diagnosis.declared_cause import declared_cause

_OF_CHANCE = ("impulse", "burst", "loss")
_OWN_SEARCH = {module.name for module in iter_modules(causes.__path__)}

CAUSES: dict[str, Cause] = {
    name: import_module(f"stillarm.diagnosis.causes.{name}").CAUSE
    if name in _OWN_SEARCH
    else declared_cause(DECLARED[name])
    for name in sorted(DECLARED)
    if DECLARED[name].acts not in _OF_CHANCE
}
