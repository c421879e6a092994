"""The causes' laws for the stepper: each compiled on its own, and called by its address.

The stepper is therefore compiled once for all causes. Each law is compiled by itself when a model first asks for it,
and kept on disk.
"""

from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

import numpy as np
from numba import cfunc, types
from numpy.typing import NDArray

from stillarm.common.causes import LAWS
from stillarm.simulation.arm.compiler import call, compiled, inlined
from stillarm.simulation.arm.state import FORCE, FREQUENCY, FRICTION, LAW, Record, Records

Array = NDArray[np.float64]

_SITES = {"force": (FORCE, 6), "friction": (FRICTION, 6), "frequency": (FREQUENCY, 3), "command": (-1, 1)}
"""By what a cause acts on: the stepper's site, and how many arguments that gives."""
_MOST_NUMBERS = 4


def laws_of(effects: Iterable[tuple[str, Mapping[str, Any]]], begin_s: float = 0.0) -> Records:
    """Records of the laws that act in the arm, (n,), of effects, each a cause with its values by name; none of idle
    ones. begin_s: instant from which they act, but those with an onset of their own."""
    rows = []
    for identifier, values in effects:
        cause = LAWS[identifier]
        site, _ = _SITES.get(cause.acts, (-1, 0))
        if site < 0 or cause.is_idle(values):
            continue
        own = cause.arguments(values)
        padded = (*own, *[0.0] * (_MOST_NUMBERS - len(own)))
        corner = site == FRICTION or cause.corner
        begin = 0.0 if "onset_s" in values else begin_s
        onset = values.get("onset_s", begin if begin > 0.0 else np.inf)
        rows.append((address_of(identifier), site, len(own), corner, cause.foreign, begin, onset, *padded))
    return np.array(rows, dtype=LAW)


@cache
def address_of(identifier: str) -> int:
    """Where the compiled law of a cause lies in memory. Raises ValueError for a law with more numbers than the stepper
    passes."""
    cause = LAWS[identifier]
    if len(cause.numbers) > _MOST_NUMBERS:
        raise ValueError(f"{identifier}: a law of over {_MOST_NUMBERS} numbers; the stepper calls none")
    arguments = [types.float64] * (_SITES[cause.acts][1] + len(cause.numbers))
    compiled: Any = cfunc(types.float64(*arguments), cache=True, error_model="numpy")(cause.law)
    return int(compiled.address)


def obeyed(effects: Iterable[tuple[str, Mapping[str, Any]]], commands: Array) -> Array:
    """Commands as the drive obeys them, rad/s, (n,), after the effects with a law for it, in their order."""
    for identifier, values in effects:
        cause = LAWS[identifier]
        if cause.acts == "command" and not cause.is_idle(values):
            commands = _each(address_of(identifier), np.array(cause.arguments(values)), commands)
    return commands


@compiled
def _each(address: int, own: Array, commands: Array) -> Array:
    out = np.empty_like(commands)
    for k in range(len(commands)):
        if len(own) == 1:
            out[k] = call(address, (commands[k], own[0]))
        elif len(own) == 2:
            out[k] = call(address, (commands[k], own[0], own[1]))
        else:
            out[k] = call(address, (commands[k], own[0], own[1], own[2]))
    return out


@inlined
def state_law(law: Record, t: float, theta: float, omega: float, q: float, v: float, w: float) -> float:
    """A law of force or friction, m/s^2."""
    if law.count == 1:
        return call(law.address, (t, theta, omega, q, v, w, law.n0))
    if law.count == 2:
        return call(law.address, (t, theta, omega, q, v, w, law.n0, law.n1))
    if law.count == 3:
        return call(law.address, (t, theta, omega, q, v, w, law.n0, law.n1, law.n2))
    return call(law.address, (t, theta, omega, q, v, w, law.n0, law.n1, law.n2, law.n3))


@inlined
def frequency_law(law: Record, t: float, mode: float, first_hz: float) -> float:
    """A law of frequency: a mode's over the declared one."""
    if law.count == 1:
        return call(law.address, (t, mode, first_hz, law.n0))
    if law.count == 2:
        return call(law.address, (t, mode, first_hz, law.n0, law.n1))
    if law.count == 3:
        return call(law.address, (t, mode, first_hz, law.n0, law.n1, law.n2))
    return call(law.address, (t, mode, first_hz, law.n0, law.n1, law.n2, law.n3))
