"""Methods of other packages. A package names them in its metadata, by the entry point group `stillarm.methods`:

    [project.entry-points."stillarm.methods"]
    my_method = "my_package:make"

`make` is called with the model, the section [controller] and the model's name, and returns a Method (estimate.py). The
group is read once in a process, and only where somebody asks for a method that is not ours.
"""

from collections.abc import Callable
from functools import cache
from importlib.metadata import EntryPoint, entry_points

from stillarm.common.files.configuration import Controller
from stillarm.common.files.model import Model
from stillarm.common.user_error import UserError
from stillarm.controller.estimation.estimate import Method

GROUP = "stillarm.methods"
MethodFactory = Callable[[Model, Controller, str], Method]
"""(model, settings, model_name) -> a new method. model_name: for messages to the user."""


@cache
def installed_methods() -> dict[str, EntryPoint]:
    """Entry points by the method's name, in the order of the names. Imports no package.

    Raises UserError where two packages give one name.
    """
    found: dict[str, EntryPoint] = {}
    for point in sorted(entry_points(group=GROUP), key=lambda one: one.name):
        other = found.setdefault(point.name, point)
        if other.value != point.value:
            raise UserError(
                f"method {point.name!r}: both {_package(other)} and {_package(point)} install it; uninstall one"
            )
    return found


@cache
def installed_factory(name: str) -> MethodFactory:
    """Import what makes a method. Raises UserError, naming the package, where that fails; KeyError without the name."""
    point = installed_methods()[name]
    try:
        factory: MethodFactory = point.load()
    except Exception as error:  # whatever a stranger's module does when it is imported
        raise UserError(
            f"method {name!r}: {point.value} of {_package(point)} cannot be imported "
            f"({type(error).__name__}: {' '.join(str(error).split())}); mend or uninstall that package"
        ) from error
    if not callable(factory):
        raise UserError(
            f"method {name!r}: {point.value} of {_package(point)} cannot be called; "
            "it has to take a model, settings and a name, and return a method"
        )
    return factory


def _package(point: EntryPoint) -> str:
    return f"{point.dist.name} {point.dist.version}" if point.dist is not None else "an unnamed package"
