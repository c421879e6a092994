"""`stillarm.diagnose(recording)` from Python; else the command line: `main.py` finds the subcommand, `commands/` has
one file for each, `preflight/` is `check`.

Logic does not belong here; a command calls the package that does the work. What Python may ask for is loaded when it is
asked for: `import stillarm` alone takes no time, in the controller's processes too. __init__.pyi has the types.
"""

from importlib import import_module
from typing import Any

_FROM = {
    "Diagnosis": "stillarm.diagnosis.notebook",
    "diagnose": "stillarm.diagnosis.notebook",
}


def __getattr__(name: str) -> Any:
    if name not in _FROM:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_FROM[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_FROM})
