"""How a cause is looked for and fitted whose declaration says all there is to know of it."""

from collections.abc import Callable
from itertools import product
from math import isnan

import numpy as np

from stillarm.common.causes import Cause as Declaration
from stillarm.common.causes import Parameter, Place
from stillarm.common.causes.declaration import OTHERS
from stillarm.diagnosis.cause import Cause, Context, Trial, arm_moves, driven, has, plain
from stillarm.diagnosis.declared_effects import quantity_of
from stillarm.diagnosis.world import World

_NEEDS: dict[Place, Callable[[World], bool]] = {
    "arm": arm_moves,
    "drive": driven,
    "accelerometer": has("acceleration"),
    "camera": has("displacement"),
    "timing": has("displacement", "arrival"),
}
_LINEAR = 0.2  # of the least that is usual: what adds to a sensor does so in proportion
_TRIED = 4  # values across the usual range


def declared_cause(cause: Declaration) -> Cause:
    """Its trials are its usual sizes, to both sides where signed, beside usual values of its other numbers."""
    names = {one.name: quantity_of(cause.identifier, one.name) for one in cause.numbers}
    sizes = [one for one in cause.numbers if _is_size(cause, one)]
    others = [one for one in cause.numbers if one not in sizes]
    moves = cause.place in ("arm", "drive")

    def shown_in(world: World) -> dict[str, str]:
        """Quantities by parameter, but for what only an arm of several modes shows."""
        alone = world.modes == 1
        return {name: quantity for name, quantity in names.items() if not (alone and name == OTHERS.name)}

    def trials(context: Context) -> list[Trial]:
        found = []
        for values in product(*(_begins(one) for one in others)):
            shape = {names[one.name]: value for one, value in zip(others, values, strict=True)}
            for amounts in zip(*(_amounts(one, moves) for one in sizes), strict=True):
                known = {names[one.name]: context.value(names[one.name]) for one in sizes}
                column = {name: known[name] + more for name, more in zip(known, amounts, strict=True)}
                one_sided = not any(one.signed for one in sizes) and not any(known.values())
                found.append(Trial(shape, (column,), one_sided=one_sided))
        return found

    return Cause(
        id=cause.identifier,
        needs=_NEEDS[cause.place],
        trials=trials,
        free=lambda world: tuple(shown_in(world).values()),
        parameters_of=lambda fit: plain(fit, **shown_in(fit.world)),
    )


def _is_size(cause: Declaration, one: Parameter) -> bool:
    return bool(cause.key) or not isnan(one.neutral)


def _begins(one: Parameter) -> tuple[float, ...]:
    """Values of a number that is no size from which a search begins."""
    if one.tried or one.default is not None:
        return one.tried or (float(one.default or 0.0),)
    return tuple(np.geomspace(*one.typical, _TRIED).tolist())


def _amounts(one: Parameter, moves: bool) -> tuple[float, ...]:
    """By how much more a size is tried."""
    low, high = one.typical
    if not moves:
        return (_LINEAR * low,)
    return (low, high, -low, -high) if one.signed else (low, high)
