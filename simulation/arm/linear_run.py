"""A whole recording of an arm on which only its joint acts, compiled: the stepper's cycle as a matrix, computed once.

Without play, and while the drive meets no limit, a cycle takes the (q, q') of each mode on which no law of a cause acts
and the joint's two accelerations theta'' (before and after a command's arrival in it) to the next (q, q') by a matrix.
The matrix is what the stepper makes of unit values, so that the equations stand there alone; what it saves
is their bookkeeping, four fifths of the time.
"""

import numpy as np
from numpy.typing import NDArray

from stillarm.simulation.arm.compiler import compiled, inlined, nth
from stillarm.simulation.arm.joint import lagging
from stillarm.simulation.arm.state import Record, Records
from stillarm.simulation.arm.stepper import free_acceleration, jumped, tune, undisturbed

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


@compiled
def linear_joint(
    arms: Records, command: Array, whole: int, out_joint: Array, out_motor: Array, out_starts: Array
) -> bool:
    """The joint over all cycles; false, with unusable results, if it meets a limit or has play.

    As free_run. out_starts: (n, 2) theta'' at the beginning of a cycle's two parts, rad/s^2.
    """
    arm, n = arms[0], len(command)
    if arm.gap > 0.0 or arm.c0 != 0.0 or arm.c1 != 0.0 or arm.c2 != 0.0:
        return False
    omega, motor, alpha, ahead = arm.rate, arm.motor, arm.acceleration, arm.ahead
    linear = arm.most / arm.decay
    for k in range(n):
        out_joint[k, 0], out_joint[k, 1], out_joint[k, 2] = motor - ahead, omega, alpha
        out_motor[k, 0], out_motor[k, 1] = motor, omega
        for part in range(2):
            duration = arm.late if part == 1 else arm.early
            lasted = arm.late_risen if part == 1 else arm.early_risen
            if duration <= 0.0:
                out_starts[k, part] = 0.0
                continue
            error = command[max(k - whole - 1 + part, 0)] - omega
            start = arm.decay * error
            most = (abs(omega) + abs(start) * duration) * duration
            if abs(error) >= linear or motor - most <= arm.lowest or motor + most >= arm.highest:
                return False
            passed, rise, alpha = lagging(omega, arm.decay, start, duration, lasted)
            motor, omega = motor + passed, omega + rise
            out_starts[k, part] = start
    arm.rate, arm.motor, arm.acceleration = omega, motor, alpha
    return True


@compiled
def linear_mode(
    arms: Records,
    i: int,
    starts: Array,
    joint: Array,
    jump_cycles: Integers,
    jumps: Array,
    out_q: Array,
    out_qdd: Array,
) -> None:
    """One mode over all cycles, moved by a joint that `linear_joint` found. joint: (n, 4), its out_joint."""
    arm, n = arms[0], len(starts)
    mode = nth(arm.mode, i)
    if mode.w == 0.0:  # as made
        tune(arm, mode, 2.0 * np.pi * mode.hz)
    matrix = np.empty((2, 5))
    matrix_of_cycle(arm, mode, matrix)
    qq, qv, qe, ql, q0 = matrix[0]
    vq, vv, ve, vl, v0 = matrix[1]
    q, v, jump = mode.q, mode.v, 0
    for k in range(n):
        q, v, jump = jumped(q, v, i, k, jump, jump_cycles, jumps)
        out_q[k, i] = q
        out_qdd[k, i] = free_acceleration(mode, joint[k, 2], q, v)
        early, late = starts[k, 0], starts[k, 1]
        q, v = q0 + qq * q + qv * v + qe * early + ql * late, v0 + vq * q + vv * v + ve * early + vl * late
    mode.q, mode.v = q, v


@compiled
def matrix_of_cycle(arm: Record, mode: Record, matrix: Array) -> None:
    """Fill in, (2, 5), what a cycle makes (q, v) of q, v, the theta'' that its two parts begin with, and one."""
    q0, v0 = _over_a_cycle(arm, mode, 0.0, 0.0, 0.0, 0.0)
    for place in range(4):
        unit = [1.0 if place == one else 0.0 for one in range(4)]
        to_q, to_v = _over_a_cycle(arm, mode, unit[0], unit[1], unit[2], unit[3])
        matrix[0, place], matrix[1, place] = to_q - q0, to_v - v0
    matrix[0, 4], matrix[1, 4] = q0, v0


@inlined
def _over_a_cycle(
    arm: Record, mode: Record, q: float, v: float, early: float, late: float
) -> tuple[float, float]:
    """A mode after a cycle whose two parts begin with these theta''."""
    if arm.early > 0.0:
        _, _, end = lagging(0.0, arm.decay, early, arm.early, arm.early_risen)
        q, v = undisturbed(arm, mode, q, v, arm.early, early, end)
    if arm.late > 0.0:
        _, _, end = lagging(0.0, arm.decay, late, arm.late, arm.late_risen)
        q, v = undisturbed(arm, mode, q, v, arm.late, late, end)
    return q, v
