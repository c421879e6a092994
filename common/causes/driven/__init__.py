"""Causes of joints that are driven by a torque, a current or a voltage, one file each; a new file is found by itself.

They stand apart from the causes of joints that follow a velocity command, as they are searched in another simulation.
gear_backlash, drive_saturation, coulomb_damping and cubic_stiffness are the same mechanism in both, and stay there.
Begin to read at declaration.py.
"""

from importlib import import_module
from pkgutil import iter_modules

from stillarm.common.causes.driven.declaration import DrivenCause

__all__ = ["DRIVEN_CAUSES", "DrivenCause"]

DRIVEN_CAUSES: dict[str, DrivenCause] = {
    module.name: import_module(f"{__name__}.{module.name}").CAUSE
    for module in iter_modules(__path__)
    if module.name != "declaration"
}
"""All of them by identifier."""
