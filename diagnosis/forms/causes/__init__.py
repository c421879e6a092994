"""All causes that change a mean, by identifier: searched as their file here says, else as their declaration does.

A file here says how a cause is looked for that needs more than its declaration says (stillarm.common.causes). Laws of
noise and timing, which change no mean, are in laws.py.
"""

from importlib import import_module
from pkgutil import iter_modules

from stillarm.common.causes import CAUSES as DECLARED
from stillarm.diagnosis.forms.cause import Cause, declared_cause

__all__ = ["CAUSES", "camera_clock_skew", "clock_step", "mains_hum", "stale_frame_buffer"]

_OF_CHANCE = ("impulse", "burst", "loss")
_OWN_SEARCH = {module.name for module in iter_modules(__path__)}
CAUSES: dict[str, Cause] = {
    name: import_module(f"stillarm.diagnosis.forms.causes.{name}").CAUSE
    if name in _OWN_SEARCH
    else declared_cause(DECLARED[name])
    for name in sorted(DECLARED)
    if DECLARED[name].acts not in _OF_CHANCE
}
