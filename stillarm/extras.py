"""Which parts of an install a command needs, and the command that adds a missing one.

The base is what the controller needs. Packages that take long to import or to fetch are extras of pyproject.toml.
"""

from collections.abc import Callable
from importlib.util import find_spec

from stillarm.common.user_error import UserError

PACKAGES = {
    "vision": ("cv2",),
    "diagnosis": ("matplotlib", "numba", "scipy", "threadpoolctl"),
    "hardware": ("can", "canopen"),
    "formats": ("h5py", "pyarrow", "rosbags"),
    "panel": ("aiohttp",),
}
"""Names under which the packages of each extra are imported."""

NEEDED_BY = {
    "demo": ("vision", "diagnosis"),
    "rig": ("vision", "diagnosis"),
    "supervisor": ("vision",),
    "track": ("vision",),
    "panel": ("panel",),
    "simulate": ("vision", "diagnosis"),
    "commission": ("diagnosis",),
    "calibrate": ("diagnosis",),
    "diagnose": ("diagnosis",),
}
"""Extras that a command cannot do without. Other commands need one only for some options."""


def require(
    command: str, is_installed: Callable[[str], bool] = lambda name: find_spec(name) is not None
) -> None:
    """Raise UserError, with the remedy, where an extra that `command` needs is not installed. Imports nothing."""
    missing = {
        extra: [name for name in PACKAGES[extra] if not is_installed(name)]
        for extra in NEEDED_BY.get(command, ())
    }
    lacking = [extra for extra, names in missing.items() if names]
    if lacking:
        packages = ", ".join(name for names in missing.values() for name in names)
        raise UserError(f"{command}: not installed here: {packages}; {_remedy(lacking)}")


def missing_package(error: ModuleNotFoundError) -> UserError | None:
    """The user's message for a package of an extra that is not installed; None for any other failed import."""
    package = (error.name or "").partition(".")[0]
    extras = [extra for extra, names in PACKAGES.items() if package in names]
    return UserError(f"not installed here: {package}; {_remedy(extras)}") if extras else None


def _remedy(extras: list[str]) -> str:
    return f"run `pip install 'stillarm[{','.join(extras)}]'`"
