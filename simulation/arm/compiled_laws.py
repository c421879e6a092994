"""The causes' laws for the stepper: each compiled on its own, and called by its address.

So the stepper is compiled once, whatever causes there are, and each law is compiled (and kept on disk) by itself, when
a model first asks for it.
"""

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import Any, NamedTuple, cast

import numpy as np
from llvmlite import ir
from numba import cfunc, njit, types
from numba.extending import intrinsic
from numpy.typing import NDArray

from common.causes import CAUSES

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

FORCE, FRICTION, FREQUENCY = 0, 1, 2
_SITES = {
    "force": (FORCE, 6),
    "friction": (FRICTION, 6),
    "frequency": (FREQUENCY, 3),
}  # and how much each gives
_MOST_NUMBERS = 4


class Laws(NamedTuple):
    """The laws that act in an arm: (n, 4) address, site, first of its numbers, how many; the numbers; (n,) onsets, s,
    at which a law breaks off, infinite where it does not."""

    table: Integers
    numbers: Array
    onsets: Array


def laws_of(effects: Iterable[tuple[str, Mapping[str, Any]]]) -> Laws:
    """Those of effects, each a cause with its values by name, that act in the arm and are not idle."""
    rows, numbers, onsets = [], list[float](), []
    for identifier, values in effects:
        cause = CAUSES[identifier]
        if cause.acts not in _SITES or cause.law is None or cause.is_idle(values):
            continue
        own = cause.arguments(values)
        site, given = _SITES[cause.acts]
        rows.append((address_of(cause.law, given + len(own)), site, len(numbers), len(own)))
        numbers += own
        onsets.append(float(values.get("onset_s", np.inf)))
    table = np.array(rows, dtype=np.int64).reshape(len(rows), 4)
    return Laws(table, np.array(numbers, dtype=np.float64), np.array(onsets, dtype=np.float64))


@cache
def address_of(law: Callable[..., float], arguments: int) -> int:
    """Where the compiled law, of so many floats, lies in memory."""
    if arguments > 6 + _MOST_NUMBERS:
        raise ValueError(
            f"{law.__module__}: a law of over {_MOST_NUMBERS} numbers of its own; the stepper calls none"
        )
    compiled: Any = cfunc(types.float64(*[types.float64] * arguments), cache=True, error_model="numpy")(law)
    return int(compiled.address)


def _call(typing_context: Any, address: Any, arguments: Any) -> Any:
    """Call the function of floats at an address with a tuple of them: type, and how the compiler is to build it."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        double = ir.DoubleType()
        count = signature.args[1].count
        pointer = builder.inttoptr(values[0], ir.FunctionType(double, [double] * count).as_pointer())
        return builder.call(pointer, [builder.extract_value(values[1], place) for place in range(count)])

    return types.float64(address, arguments), generate


call: Callable[[int, tuple[float, ...]], float] = cast(Any, intrinsic(_call))


@njit(cache=True, nogil=True, error_model="numpy")
def state_law(
    laws: Laws, row: int, t: float, theta: float, omega: float, q: float, v: float, w: float
) -> float:
    """A law of force or friction, m/s^2."""
    address, first, count = laws.table[row, 0], laws.table[row, 2], laws.table[row, 3]
    own = laws.numbers
    if count == 1:
        return call(address, (t, theta, omega, q, v, w, own[first]))
    if count == 2:
        return call(address, (t, theta, omega, q, v, w, own[first], own[first + 1]))
    if count == 3:
        return call(address, (t, theta, omega, q, v, w, own[first], own[first + 1], own[first + 2]))
    return call(
        address, (t, theta, omega, q, v, w, own[first], own[first + 1], own[first + 2], own[first + 3])
    )


@njit(cache=True, nogil=True, error_model="numpy")
def frequency_law(laws: Laws, row: int, t: float, mode: float, first_hz: float) -> float:
    """A law of frequency: a mode's over the declared one."""
    address, first, count = laws.table[row, 0], laws.table[row, 2], laws.table[row, 3]
    own = laws.numbers
    if count == 1:
        return call(address, (t, mode, first_hz, own[first]))
    if count == 2:
        return call(address, (t, mode, first_hz, own[first], own[first + 1]))
    if count == 3:
        return call(address, (t, mode, first_hz, own[first], own[first + 1], own[first + 2]))
    return call(address, (t, mode, first_hz, own[first], own[first + 1], own[first + 2], own[first + 3]))
