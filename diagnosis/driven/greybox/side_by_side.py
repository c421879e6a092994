"""The blocks of a recording simulated side by side, for what the sensors show alone: the inner loop of every fit.

The equations of motion are those of stillarm.simulation.arm.torque_joint. That runs block after block and keeps the
whole state. Here sixteen blocks go on together: each loop over them has a length that the compiler knows, in one array
whose rows it can tell apart, so that the processor works on several numbers at once. Laws that are off cost nothing;
and of the state only what the sensors make of it is written down. Numbers are the same but for rounding.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.driven.greybox import vectorised
from stillarm.diagnosis.driven.greybox.vectorised import faded, sine_cosine
from stillarm.simulation.arm import torque_joint
from stillarm.simulation.arm.compiler import compiled_from, inlined
from stillarm.simulation.arm.torque_joint import (
    CN,
    CP,
    GC,
    GS,
    K3,
    OFF,
    Q3,
    QC,
    RC,
    RN,
    RS,
    SN,
    SP,
    SV,
    TINY,
    V2,
    VA,
)  # fmt: skip

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

BESIDE = 16
"""Blocks that go on together: as many as a recording usually has, and few enough to stay in the nearest cache."""
_SMOOTH, _RUBS = [V2, VA, RS, RC, GS, GC, OFF, K3], [CP, CN, SP, SN]
PUSH, FORWARD, BACKWARD, SHOWN, STATE = 0, 1, 2, 3, 9
"""Rows of a stepper's array, BESIDE numbers each: what `push_joint`, `limit_friction` and `show` fill in, and the first
of the states' components; between them are the stepper's own."""
_RUB, _FORCE, _RUB_ARM, _BEGINS, _ENDS = range(4, 9)
_TILE, _MOST_TILED = 4, 12  # rows of a product that a compiler unrolls; components of a state with five modes


@inlined
def push_joint(law: Array, step_s: float, work: Array, theta: int, omega: int) -> None:
    """Fill in what the smooth laws push the joint by, rad/s^2, at the step's middle. theta, omega: the joint's rows."""
    for b in range(BESIDE):
        rate = work[omega * BESIDE + b]
        middle = work[theta * BESIDE + b] + 0.5 * step_s * rate
        work[PUSH * BESIDE + b] = (
            law[OFF] - (law[V2] * rate + law[VA]) * abs(rate) - law[K3] * middle * middle * middle
        )
    if law[RS] != 0.0 or law[RC] != 0.0:
        for b in range(BESIDE):
            middle = work[theta * BESIDE + b] + 0.5 * step_s * work[omega * BESIDE + b]
            sine, cosine = sine_cosine(law[RN] * middle)
            work[PUSH * BESIDE + b] += law[RS] * sine + law[RC] * cosine
    if law[GS] != 0.0 or law[GC] != 0.0:
        for b in range(BESIDE):
            middle = work[theta * BESIDE + b] + 0.5 * step_s * work[omega * BESIDE + b]
            sine, cosine = sine_cosine(middle)
            work[PUSH * BESIDE + b] += law[GS] * sine + law[GC] * cosine


@inlined
def limit_friction(law: Array, work: Array, omega: int) -> None:
    """Fill in the largest dry friction against forward and against backward motion, rad/s^2."""
    if law[SV] > TINY and (law[SP] != 0.0 or law[SN] != 0.0):
        for b in range(BESIDE):
            fade = faded(work[omega * BESIDE + b] / law[SV])
            work[FORWARD * BESIDE + b] = max(law[CP] + law[SP] * fade, 0.0)
            work[BACKWARD * BESIDE + b] = max(law[CN] + law[SN] * fade, 0.0)
    else:
        for b in range(BESIDE):
            work[FORWARD * BESIDE + b] = max(law[CP], 0.0)
            work[BACKWARD * BESIDE + b] = max(law[CN], 0.0)


def laws_on(law: Array) -> tuple[bool, bool]:
    """Whether any smooth law pushes the joint, and whether any rubs."""
    return bool(np.any(law[_SMOOTH])), bool(np.any(law[_RUBS]))


def is_linear(law: Array) -> bool:
    """Whether no law acts, on the joint or on the arm."""
    return not np.any(law[[*_SMOOTH, *_RUBS, Q3, QC]])


@inlined
def begin_group(
    group: int, starts: Integers, states: Array, work: Array, first: Integers, length: Integers
) -> int:
    """Fill in where the blocks from `group` on begin, how long they are, and their states' components there, one row
    each from STATE on; returns the longest. A place without a block runs as the last one, unseen."""
    longest, blocks = 0, len(starts) - 1
    for b in range(BESIDE):
        block = min(group + b, blocks - 1)
        first[b], length[b] = starts[block], starts[block + 1] - starts[block]
        longest = max(longest, length[b])
        for i in range(states.shape[1]):
            work[(STATE + i) * BESIDE + b] = states[block, i]
    return longest


@inlined
def _tile(begin: int, rows: int, n: int, phi: Array, work: Array) -> None:
    for b in range(BESIDE):
        for i in range(begin, begin + rows):
            total = 0.0
            for j in range(n):
                total += phi[i, j] * work[(STATE + j) * BESIDE + b]
            work[(STATE + n + i) * BESIDE + b] = total


@inlined
def advance(n: int, phi: Array, work: Array) -> None:
    """Fill in the n rows behind those of the states with phi times these, in tiles that the compiler unrolls."""
    if n <= _MOST_TILED:
        _tile(0, min(n, _TILE), n, phi, work)
        if n > _TILE:
            _tile(_TILE, min(n - _TILE, _TILE), n, phi, work)
        if n > 2 * _TILE:
            _tile(2 * _TILE, n - 2 * _TILE, n, phi, work)
    else:
        for i in range(n):
            _tile(i, 1, n, phi, work)


@inlined
def show(
    sensor: int,
    n: int,
    many: int,
    by_state: Array,
    work: Array,
    k: int,
    length: Integers,
    places: Integers,
    out: Array,
) -> None:
    """Add what a sensor shows of the state to the row SHOWN, and write down that of the first `many` blocks, as far as
    they have a sample k."""
    for b in range(BESIDE):
        total = work[SHOWN * BESIDE + b]
        for j in range(n):
            total += by_state[sensor, j] * work[(STATE + j) * BESIDE + b]
        work[SHOWN * BESIDE + b] = total
    for b in range(many):
        if k < length[b]:
            out[places[sensor, b] + k] = work[SHOWN * BESIDE + b]


def run_side_by_side(
    phi: Array, g: Array, law: Array, u: Array, substeps: int, step_s: float, starts: Integers, states: Array,
    by_state: Array, by_force: Array, places: Integers, out: Array,
) -> None:  # fmt: skip
    """Free runs over all blocks.

    phi: (n, n), g: (n, 4) of a substep (`transition`). law: (l,). u: (samples substeps, 2) at each substep's start and
    end. starts: (blocks + 1,) first sample of each, and the end; states: (blocks, n) there. by_state: (m, n) and
    by_force: (m, 3), what each sensor shows of the state, of the input and of the forces on joint and first mode just
    after a sample. places: (m, blocks), where in `out` a sensor's samples of a block begin.
    """
    stepper = _stepper_of(len(phi))
    stepper(phi, g, law, *laws_on(law), u, substeps, step_s, starts, states, by_state, by_force, places, out)


@cache
def _stepper_of(n: int) -> Callable[..., None]:
    """Compiled for states of so many components."""

    @compiled_from(__file__, torque_joint.__file__, vectorised.__file__)
    def stepper(
        phi: Array, g: Array, law: Array, pushes: bool, rubs: bool, u: Array, substeps: int, step_s: float,
        starts: Integers, states: Array, by_state: Array, by_force: Array, places: Integers, out: Array,
    ) -> None:  # fmt: skip
        blocks, work = len(starts) - 1, np.zeros((STATE + 2 * n) * BESIDE)
        first, length = np.zeros(BESIDE, np.int64), np.zeros(BESIDE, np.int64)
        row = np.zeros(BESIDE, np.int64)
        bends, arm_rubs = n > 2 and law[Q3] != 0.0, n > 2 and law[QC] > 0.0
        for group in range(0, blocks, BESIDE):
            longest = begin_group(group, starts, states, work, first, length)
            many = min(BESIDE, blocks - group)
            for k in range(longest):
                for b in range(BESIDE):
                    row[b] = (first[b] + min(k, length[b] - 1)) * substeps
                for s in range(substeps):
                    for b in range(BESIDE):
                        work[_BEGINS * BESIDE + b] = u[row[b] + s, 0]
                        work[_ENDS * BESIDE + b] = u[row[b] + s, 1]
                    if pushes:
                        push_joint(law, step_s, work, STATE, STATE + 1)
                    if bends:
                        _bend(law, step_s, work)
                    advance(n, phi, work)
                    _push(n, g, work)
                    if rubs:
                        limit_friction(law, work, STATE + 1)
                        _rub(n, g, work)
                    if arm_rubs:
                        _rub_arm(n, g, law[QC], work)
                    if s == 0:
                        for o in range(len(by_state)):
                            _show_forces(by_force[o], work)
                            show(o, n, many, by_state, work, k, length, places[:, group:], out)
                    for b in range(n * BESIDE):
                        work[STATE * BESIDE + b] = work[(STATE + n) * BESIDE + b]

    return stepper


@inlined
def _bend(law: Array, step_s: float, work: Array) -> None:
    for b in range(BESIDE):
        middle = work[(STATE + 2) * BESIDE + b] + 0.5 * step_s * work[(STATE + 3) * BESIDE + b]
        work[_FORCE * BESIDE + b] = -law[Q3] * middle * middle * middle


@inlined
def _push(n: int, g: Array, work: Array) -> None:
    for b in range(BESIDE):
        for i in range(n):
            work[(STATE + n + i) * BESIDE + b] += (
                g[i, 0] * work[_BEGINS * BESIDE + b] + g[i, 1] * work[_ENDS * BESIDE + b]
                + g[i, 2] * work[PUSH * BESIDE + b] + g[i, 3] * work[_FORCE * BESIDE + b]
            )  # fmt: skip


@inlined
def _show_forces(by_force: Array, work: Array) -> None:
    for b in range(BESIDE):
        torque = work[PUSH * BESIDE + b] + work[_RUB * BESIDE + b]
        force = work[_FORCE * BESIDE + b] + work[_RUB_ARM * BESIDE + b]
        work[SHOWN * BESIDE + b] = (
            by_force[0] * work[_BEGINS * BESIDE + b] + by_force[1] * torque + by_force[2] * force
        )


@inlined
def _rub(n: int, g: Array, work: Array) -> None:
    for b in range(BESIDE):
        stops = -work[(STATE + n + 1) * BESIDE + b] / g[1, 2]
        rub = min(max(stops, -work[FORWARD * BESIDE + b]), work[BACKWARD * BESIDE + b])
        work[_RUB * BESIDE + b] = rub
        for i in range(n):
            work[(STATE + n + i) * BESIDE + b] += g[i, 2] * rub


@inlined
def _rub_arm(n: int, g: Array, limit: float, work: Array) -> None:
    for b in range(BESIDE):
        rub = min(max(-work[(STATE + n + 3) * BESIDE + b] / g[3, 3], -limit), limit)
        work[_RUB_ARM * BESIDE + b] = rub
        for i in range(n):
            work[(STATE + n + i) * BESIDE + b] += g[i, 3] * rub


__all__ = [
    "BACKWARD",
    "BESIDE",
    "FORWARD",
    "PUSH",
    "SHOWN",
    "STATE",
    "advance",
    "begin_group",
    "is_linear",
    "laws_on",
    "limit_friction",
    "push_joint",
    "run_side_by_side",
    "show",
]  # fmt: skip
