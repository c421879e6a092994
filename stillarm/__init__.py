"""stillarm from Python: `load`, `replay`, `simulate`, `diagnose`, `Model`, and the types of an estimator of your own.

Else the command line: `main.py` finds the subcommand, `commands/` has one file for each, `preflight/` is `check`.
api/ is what stands behind this module. Logic does not belong here; a command calls the package that does the work.

Each name is loaded on first use: `import stillarm` alone takes no time, in the controller's processes too.
__init__.pyi has the types.
"""

from importlib import import_module
from typing import Any

_FROM = {
    "Channels": "stillarm.api.channels",
    "DelayEstimate": "stillarm.controller.estimation.estimate",
    "DelayEstimator": "stillarm.controller.estimation.sine_method",
    "Diagnosis": "stillarm.diagnosis.notebook",
    "Estimate": "stillarm.controller.estimation.estimate",
    "Method": "stillarm.controller.estimation.estimate",
    "MethodFactory": "stillarm.controller.estimation.methods",
    "Model": "stillarm.common.files.model",
    "Observation": "stillarm.controller.estimation.estimate",
    "Replayed": "stillarm.api.replaying",
    "Simulated": "stillarm.api.simulating",
    "Status": "stillarm.controller.estimation.estimate",
    "Table": "stillarm.api.channels",
    "UserError": "stillarm.common.user_error",
    "VisualSample": "stillarm.common.datagrams.visual_sample",
    "diagnose": "stillarm.diagnosis.notebook",
    "load": "stillarm.api.channels",
    "replay": "stillarm.api.replaying",
    "simulate": "stillarm.api.simulating",
    "with_sine_prediction": "stillarm.controller.estimation.methods",
}


def __getattr__(name: str) -> Any:
    if name not in _FROM:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_FROM[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_FROM})
