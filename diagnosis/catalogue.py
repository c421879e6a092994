"""All deterministic causes, by identifier; laws of noise and timing are in laws.py."""

from importlib import import_module
from pkgutil import iter_modules

from diagnosis import causes
from diagnosis.cause import Cause

CAUSES: dict[str, Cause] = {
    name: import_module(f"diagnosis.causes.{name}").CAUSE
    for name in sorted(module.name for module in iter_modules(causes.__path__))
}
