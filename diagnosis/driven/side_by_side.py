"""The blocks of a recording simulated side by side, for what the sensors show alone: the inner loop of every fit.

The equations of motion are those of stillarm.simulation.arm.torque_joint, whose laws are called here, and its numbers
come out to the last bit. That runs block after block and keeps the whole state. Here some blocks go on together, so
that the processor has independent numbers to work on; laws that are off cost nothing; and of the state only what the
sensors make of it is written down.
"""

from math import ceil

import numpy as np
from numpy.typing import NDArray

from stillarm.simulation.arm.compiler import compiled_from
from stillarm.simulation.arm.torque_joint import LAWS, friction_limits, smooth_torque

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

_MOST_BESIDE = (
    16  # blocks that go on together: as many as a recording usually has, and few enough to stay in cache
)
_AT_ONCE = 4  # numbers that a processor multiplies at once
_RUBS = np.array([name.startswith(("coulomb_", "stribeck_p", "stribeck_n")) for name in LAWS])
_SMOOTH = np.array(
    [name not in ("stribeck_velocity", "ripple_cycles", "arm_cubic", "arm_coulomb") for name in LAWS]
)
_SMOOTH &= ~_RUBS
_ARM_CUBIC, _ARM_COULOMB = LAWS.index("arm_cubic"), LAWS.index("arm_coulomb")


def many_beside(blocks: int) -> int:
    """How many of the blocks go on together."""
    return min(_AT_ONCE * ceil(blocks / _AT_ONCE), _MOST_BESIDE)


def laws_on(law: Array) -> tuple[bool, bool]:
    """Whether any law pushes the joint, and whether any rubs."""
    return bool(np.any(law[_SMOOTH])), bool(np.any(law[_RUBS]))


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
    beside = many_beside(len(starts) - 1)
    _run(
        phi,
        g,
        law,
        *laws_on(law),
        beside,
        u,
        substeps,
        step_s,
        starts,
        states,
        by_state,
        by_force,
        places,
        out,
    )


@compiled_from(__file__)
def begin_group(
    group: int, starts: Integers, states: Array, z: Array, first: Integers, length: Integers
) -> int:
    """Fill in where the blocks from `group` on begin, how long they are, and the state at their starts, z: (n, beside);
    returns the longest. A place without a block runs as the last one, unseen."""
    longest, blocks = 0, len(starts) - 1
    for b in range(len(first)):
        block = min(group + b, blocks - 1)
        first[b], length[b] = starts[block], starts[block + 1] - starts[block]
        longest = max(longest, length[b])
        for i in range(z.shape[0]):
            z[i, b] = states[block, i]
    return longest


@compiled_from(__file__)
def _run(  # noqa: PLR0912 (in one loop, as each call inside it would cost as much as its body)
    phi: Array, g: Array, law: Array, pushes: bool, rubs: bool, beside: int, u: Array, substeps: int,
    step_s: float, starts: Integers, states: Array, by_state: Array, by_force: Array, places: Integers, out: Array,
) -> None:  # fmt: skip
    n, m, blocks = phi.shape[0], by_state.shape[0], len(starts) - 1
    z, new = np.zeros((n, beside)), np.zeros((n, beside))
    push, force, rub, rub_arm = np.zeros(beside), np.zeros(beside), np.zeros(beside), np.zeros(beside)
    begins, ends, shown = np.zeros(beside), np.zeros(beside), np.zeros(beside)
    first, length = np.zeros(beside, np.int64), np.zeros(beside, np.int64)
    bends, arm_rubs = n > 2 and law[_ARM_CUBIC] != 0.0, n > 2 and law[_ARM_COULOMB] > 0.0
    for group in range(0, blocks, beside):
        longest = begin_group(group, starts, states, z, first, length)
        here = min(beside, blocks - group)
        for k in range(longest):
            for s in range(substeps):
                for b in range(beside):
                    at = (first[b] + min(k, length[b] - 1)) * substeps + s
                    begins[b], ends[b] = u[at, 0], u[at, 1]
                if pushes:
                    for b in range(beside):
                        push[b] = smooth_torque(law, z[0, b] + 0.5 * step_s * z[1, b], z[1, b])
                if bends:
                    for b in range(beside):
                        middle = z[2, b] + 0.5 * step_s * z[3, b]
                        force[b] = -law[_ARM_CUBIC] * middle * middle * middle
                for i in range(n):
                    for b in range(beside):
                        new[i, b] = (
                            g[i, 0] * begins[b] + g[i, 1] * ends[b] + g[i, 2] * push[b] + g[i, 3] * force[b]
                        )
                    for j in range(0, n, 2):
                        for b in range(beside):
                            new[i, b] = (new[i, b] + phi[i, j] * z[j, b]) + phi[i, j + 1] * z[j + 1, b]
                if rubs:
                    for b in range(beside):
                        forward, backward = friction_limits(law, z[1, b])
                        rub[b] = min(max(-new[1, b] / g[1, 2], -forward), backward)
                    for i in range(n):
                        for b in range(beside):
                            new[i, b] += g[i, 2] * rub[b]
                if arm_rubs:
                    for b in range(beside):
                        rub_arm[b] = min(max(-new[3, b] / g[3, 3], -law[_ARM_COULOMB]), law[_ARM_COULOMB])
                    for i in range(n):
                        for b in range(beside):
                            new[i, b] += g[i, 3] * rub_arm[b]
                if s == 0:
                    for o in range(m):
                        for b in range(beside):
                            shown[b] = by_force[o, 0] * begins[b] + by_force[o, 1] * (push[b] + rub[b])
                            shown[b] += by_force[o, 2] * (force[b] + rub_arm[b])
                        for j in range(0, n, 2):
                            for b in range(beside):
                                shown[b] = (shown[b] + by_state[o, j] * z[j, b]) + by_state[o, j + 1] * z[
                                    j + 1, b
                                ]
                        for b in range(here):
                            if k < length[b]:
                                out[places[o, group + b] + k] = shown[b]
                for i in range(n):
                    for b in range(beside):
                        z[i, b] = new[i, b]


__all__ = ["begin_group", "laws_on", "many_beside", "run_side_by_side"]
