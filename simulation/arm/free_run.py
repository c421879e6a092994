"""The arm over a whole recording at once, under known commands: the simulation that every fit and every candidate
runs."""

import numpy as np
from numpy.typing import NDArray

from stillarm.simulation.arm.compiler import compiled, inlined, nth
from stillarm.simulation.arm.linear_run import linear_joint, linear_mode
from stillarm.simulation.arm.run_under_laws import mode_under_foreign_forces, mode_under_laws
from stillarm.simulation.arm.state import Record, Records
from stillarm.simulation.arm.stepper import acceleration, cycle, jumped, link, modes_through

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

_NEAR = 0.2  # cycles between a sensor's reading and a command's arrival, at which either may come first


@compiled
def free_run(
    arms: Records,
    command: Array,
    whole: int,
    jump_cycles: Integers,
    jumps: Array,
    out_joint: Array,
    out_motor: Array,
    out_q: Array,
    out_qdd: Array,
) -> None:
    """Free run over all cycles, from the arm's state on.

    command: (n,) rad/s that the drive aims at once it has arrived, `whole` cycles and the joint's early part of one
    after its own; before the first it aimed at that. jump_cycles: (j,) ascending; jumps: (j, m, 2) added to q_i and
    q_i' at the start of that cycle. Fills out_joint (n, 4): theta, theta', theta'' of the joint, and by how much
    theta'' jumps with a command that arrives near the start of the cycle (`reads_later`), less the further from it;
    out_motor (n, 2): of the motor; out_q (n, m) and out_qdd (n, m): q_i and q_i'' at the start of each cycle.
    """
    starts = np.empty((len(command), 2))
    if joint_run(arms, command, whole, out_joint, out_motor, starts):
        modes_run(arms, starts, out_joint, jump_cycles, jumps, out_q, out_qdd)
    else:
        stepped_run(arms, command, whole, jump_cycles, jumps, out_joint, out_motor, out_q, out_qdd)


@compiled
def stepped_run(
    arms: Records,
    command: Array,
    whole: int,
    jump_cycles: Integers,
    jumps: Array,
    out_joint: Array,
    out_motor: Array,
    out_q: Array,
    out_qdd: Array,
) -> None:
    """free_run cycle by cycle, whatever the joint meets."""
    arm, n, m = arms[0], len(command), arms[0].modes
    dt = arm.early + arm.late
    fraction, near = _nearness(arm)
    next_jump, jump = 0, 0.0
    for k in range(n):
        next_jump = _all_jumped(arm, k, next_jump, jump_cycles, jumps)
        out_joint[k, 0], out_joint[k, 1], out_joint[k, 2] = link(arm)
        out_joint[k, 3] = jump
        out_motor[k, 0], out_motor[k, 1] = arm.motor, arm.rate
        for i in range(m):
            out_q[k, i] = nth(arm.mode, i).q
            out_qdd[k, i] = acceleration(arm, i, k * dt)
        older, newer = max(k - whole - 1, 0), max(k - whole, 0)
        cycle(arm, k * dt, command[older], command[newer])
        beside, jump = _beside(k, whole, fraction), 0.0
        if near > 0.0 and beside < n and not _still(arm):
            _, omega, alpha = link(arm)
            jump = near * _jump_of(arm, omega, alpha, command[beside], fraction < 0.5)


@compiled
def joint_run(
    arms: Records, command: Array, whole: int, out_joint: Array, out_motor: Array, out_starts: Array
) -> bool:
    """The joint alone, as far as it meets no limit and has no play; false, with unusable results, where it does.

    As free_run. out_starts: (n, 2) theta'' at the beginning of a cycle's two parts, rad/s^2, for `modes_run`.
    """
    if not linear_joint(arms, command, whole, out_joint, out_motor, out_starts):
        return False
    _jumps_of_theta(arms[0], command, whole, out_joint)
    return True


@compiled
def modes_run(
    arms: Records,
    starts: Array,
    joint: Array,
    jump_cycles: Integers,
    jumps: Array,
    out_q: Array,
    out_qdd: Array,
) -> None:
    """The modes over all cycles, moved by a joint that `joint_run` found; as free_run."""
    arm = arms[0]
    for i in range(arm.modes):
        if i == 0 and arm.pushes != 0 and arm.foreign != 0 and arm.changes == 0:
            mode_under_foreign_forces(arms, starts, joint, jump_cycles, jumps, out_q, out_qdd)
        elif arm.changes != 0 or (i == 0 and arm.pushes != 0):
            mode_under_laws(arms, i, starts, joint, jump_cycles, jumps, out_q, out_qdd)
        else:
            linear_mode(arms, i, starts, joint, jump_cycles, jumps, out_q, out_qdd)


@inlined
def _all_jumped(arm: Record, k: int, next_jump: int, jump_cycles: Integers, jumps: Array) -> int:
    """The same of all modes as `jumped` of one."""
    after = next_jump
    for i in range(arm.modes):
        mode = nth(arm.mode, i)
        mode.q, mode.v, after = jumped(mode.q, mode.v, i, k, next_jump, jump_cycles, jumps)
    return after


@inlined
def _nearness(arm: Record) -> tuple[float, float]:
    """Fraction of a cycle before a command's arrival, and how near that is to the cycle's ends, 0 to 1."""
    fraction = arm.early / (arm.early + arm.late)
    return fraction, max(0.0, 1.0 - min(fraction, 1.0 - fraction) / _NEAR)


@inlined
def _beside(k: int, whole: int, fraction: float) -> int:
    """The command that arrives just after cycle k's end, or that was obeyed until just before it."""
    return max(k - whole + 1, 0) if fraction < 0.5 else max(k - whole - 1, 0)


@compiled
def _jumps_of_theta(arm: Record, command: Array, whole: int, out_joint: Array) -> None:
    """Fill in by how much theta'' jumps near the start of each cycle, of a joint that meets no limit."""
    fraction, near = _nearness(arm)
    out_joint[0, 3] = 0.0
    for k in range(1, len(command)):
        beside = _beside(k - 1, whole, fraction)
        out_joint[k, 3] = 0.0
        if near > 0.0 and beside < len(command):
            omega, alpha = out_joint[k, 1], out_joint[k, 2]
            out_joint[k, 3] = near * _jump_of(arm, omega, alpha, command[beside], fraction < 0.5)


@inlined
def _still(arm: Record) -> bool:
    """Whether the link is crossed by the motor within the play, or stands at an end stop."""
    return bool((arm.gap > 0.0 and arm.contact == 0.0) or not arm.lowest < arm.motor < arm.highest)


@inlined
def _jump_of(arm: Record, omega: float, alpha: float, command: float, to_come: bool) -> float:
    """Jump of theta'' when the drive's aim becomes `command`, or leaves it."""
    beside: float = min(max(arm.decay * (command - omega), -arm.most), arm.most)
    return beside - alpha if to_come else alpha - beside


@compiled
def driven_run(
    arms: Records,
    force: Array,
    dt: float,
    substeps: int,
    jump_cycles: Integers,
    jumps: Array,
    out_q: Array,
    out_qdd: Array,
) -> None:
    """Free run of modes at a joint that stands still, the first under a known force; as free_run else.

    force: (2 n substeps + 1,) acceleration of the first mode, m/s^2, at the ends and the middle of each substep.
    """
    arm, stretch, n, m = arms[0], arms[0].stretch, len(out_q), arms[0].modes
    h = dt / substeps
    stretch.duration, stretch.decay, stretch.start, stretch.end = h, 0.0, 0.0, 0.0
    stretch.jump, stretch.theta, stretch.omega = 0.0, 0.0, 0.0
    next_jump = 0
    for k in range(n):
        next_jump = _all_jumped(arm, k, next_jump, jump_cycles, jumps)
        for i in range(m):
            out_q[k, i] = nth(arm.mode, i).q
        for part in range(substeps):
            at = 2 * (k * substeps + part)
            before, between, after = force[at], force[at + 1], force[at + 2]
            arm.c0 = before
            arm.c1 = (4.0 * between - 3.0 * before - after) / h
            arm.c2 = 2.0 * (before + after - 2.0 * between) / (h * h)
            for i in range(m if part == 0 else 0):
                out_qdd[k, i] = acceleration(arm, i, k * dt)
            modes_through(arm, k * dt + part * h, 1)


def reads_later(dead_s: float, dt: float) -> bool:
    """Whether `free_run` has the sensors read after a command's arrival that is near: it is just before the cycle."""
    return bool(dead_s / dt - np.floor(dead_s / dt + 1e-9) > 0.5)
