"""What an extended plant adds to the linear equations: force terms on the modes and rules on the drive's
command.

The model file names each as an effect by its cause. The table of the causes that the plant obeys is empty so
far: an effect in the model is refused rather than passed over, since whoever simulates it would take it for
obeyed.
"""

from collections.abc import Callable
from typing import Protocol

from common.model import Model
from common.user_error import UserError


class ForceTerm(Protocol):
    """An acceleration of a mode that depends on its state: cubic stiffness, dry friction, a periodic
    disturbance."""

    def acceleration_m_s2(
        self, mode: int, deflection_m: float, rate_m_s: float, time_s: float, duration_s: float
    ) -> float:
        """Mean of the acceleration of mode number `mode` (1 = first) over the next `duration_s`.

        The duration lets dry friction stop a motion instead of reversing it; 0 asks for the present value.
        """


CommandRule = Callable[[float], float]
"""A rule of the drive, such as a dead band: velocity command after dead time and limit -> the one obeyed,
rad/s."""

SUPPORTED_CAUSES: frozenset[str] = frozenset()


def unsupported_effects(model: Model) -> list[str]:
    """Causes among the model's effects that the simulated plant does not obey, in the file's order."""
    return [cause for effect in model.effects if (cause := str(effect.get("cause"))) not in SUPPORTED_CAUSES]


def refuse_unsupported_effects(model: Model, name: str) -> None:
    """Raise UserError, naming the first cause that is not supported; `name` stands for the model's file."""
    for cause in unsupported_effects(model):
        allowed = ", ".join(sorted(SUPPORTED_CAUSES)) or "none so far"
        raise UserError(
            f"{name}: effects: cause = {cause!r}: the simulation does not support it (supported: {allowed}); "
            "remove this [[effects]] entry"
        )
