"""A mode on which laws of causes act over a whole recording, moved by a joint that meets no limit, compiled.

Where only the frequency changes, and smoothly, a cycle is linear (linear_run.py) with a matrix that changes slowly: it
is worked out at the ends and the middle of a block of cycles and interpolated by a parabola between. Within a cycle the
frequency is taken for constant, at its middle: an error of dt^2 w'/6 of the amplitude a second. What changes faster,
and what is pushed or rubbed, goes through the stepper's own functions, cycle by cycle. A force that does not depend on
what the mode does is no more than an input: of the stepper's method of fourth order Simpson's rule is left.
"""

import numpy as np
from numpy.typing import NDArray

from stillarm.simulation.arm.compiler import compiled, inlined, nth
from stillarm.simulation.arm.joint import lagging, risen, way
from stillarm.simulation.arm.linear_run import matrix_of_cycle
from stillarm.simulation.arm.state import Record, Records
from stillarm.simulation.arm.stepper import (
    acceleration_at,
    by_laws,
    free_acceleration,
    jumped,
    pushed,
    ratio_at,
    transition,
    tune,
)

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

_BLOCK = 64  # cycles: a matrix costs as much as some ten of them
_SMOOTH = 1e-8  # of a frequency, off its parabola: 3 Hz for a minute turn by 1e-5 rad more or less
_A_THIRD = 1.0 / 3.0  # of a block: where a parabola through its ends and middle is checked


@compiled
def mode_under_laws(
    arms: Records,
    i: int,
    starts: Array,
    joint: Array,
    jump_cycles: Integers,
    jumps: Array,
    out_q: Array,
    out_qdd: Array,
) -> None:
    """One mode over all cycles under the arm's laws; as linear_mode."""
    arm, n = arms[0], len(starts)
    mode, dt = nth(arm.mode, i), arm.early + arm.late
    forced, jump, k = i == 0 and arm.pushes != 0, 0, 0
    matrices, frequencies = np.empty((3, 2, 5)), np.empty(3)
    while k < n:
        end = min(k + _BLOCK, n)
        block_begins = k * dt
        smooth = not forced and end - k == _BLOCK and _is_smooth(arm, i, block_begins, _BLOCK * dt)
        if smooth:
            for point in range(3):
                at = block_begins + 0.5 * point * _BLOCK * dt
                tune(arm, mode, 2.0 * np.pi * mode.hz * ratio_at(arm, i, at))
                frequencies[point] = mode.w
                matrix_of_cycle(arm, mode, matrices[point])
        for cycle in range(k, end):
            mode.q, mode.v, jump = jumped(mode.q, mode.v, i, cycle, jump, jump_cycles, jumps)
            out_q[cycle, i] = mode.q
            if smooth:
                x = (cycle - k) / _BLOCK
                w = _parabola(frequencies[0], frequencies[1], frequencies[2], x)
                free = mode.force - mode.push * joint[cycle, 2]
                out_qdd[cycle, i] = free - w * (2.0 * mode.zeta * mode.v + w * mode.q)
                _by_matrix(mode, matrices, x + 0.5 / _BLOCK, starts[cycle, 0], starts[cycle, 1])
            else:
                theta, omega, alpha = joint[cycle, 0], joint[cycle, 1], joint[cycle, 2]
                out_qdd[cycle, i] = acceleration_at(arm, i, cycle * dt, theta, omega, alpha)
                _by_stepper(arm, i, cycle * dt, theta, omega, starts[cycle, 0], starts[cycle, 1])
        k = end


@compiled
def mode_under_foreign_forces(
    arms: Records,
    starts: Array,
    joint: Array,
    jump_cycles: Integers,
    jumps: Array,
    out_q: Array,
    out_qdd: Array,
) -> None:
    """The first mode over all cycles under forces that follow from time and joint alone; as linear_mode."""
    arm, n = arms[0], len(starts)
    mode, dt = arm.mode, arm.early + arm.late
    if mode.w == 0.0:  # as made
        tune(arm, mode, 2.0 * np.pi * mode.hz)
    matrix = np.empty((2, 5))
    matrix_of_cycle(arm, mode, matrix)
    _, half_q, _, half_v = transition(mode, 0.5 * dt)
    _, whole_q, _, whole_v = transition(mode, dt)
    sixth, jump, force = dt / 6.0, 0, np.nan
    for k in range(n):
        q, v, jump = jumped(mode.q, mode.v, 0, k, jump, jump_cycles, jumps)
        t, theta, omega, alpha = k * dt, joint[k, 0], joint[k, 1], joint[k, 2]
        mode.q, mode.v, early, late = q, v, starts[k, 0], starts[k, 1]
        out_q[k, 0] = q
        if _breaks(arm, t, dt):
            out_qdd[k, 0] = acceleration_at(arm, 0, t, theta, omega, alpha)
            _by_stepper(arm, 0, t, theta, omega, early, late)
            force = np.nan
            continue
        if np.isnan(force):
            force, _ = pushed(arm, t, theta, omega, 0.0, 0.0, mode.w)
        out_qdd[k, 0] = free_acceleration(mode, alpha, q, v) + force
        half_theta, half_omega = _joint_after(arm, theta, omega, early, late, 0.5 * dt)
        middle, _ = pushed(arm, t + 0.5 * dt, half_theta, half_omega, 0.0, 0.0, mode.w)
        theta, omega = _joint_after(arm, theta, omega, early, late, dt)
        end, _ = pushed(arm, t + dt, theta, omega, 0.0, 0.0, mode.w)
        mode.q = (
            matrix[0, 0] * q + matrix[0, 1] * v + matrix[0, 2] * early + matrix[0, 3] * late + matrix[0, 4]
        )
        mode.v = (
            matrix[1, 0] * q + matrix[1, 1] * v + matrix[1, 2] * early + matrix[1, 3] * late + matrix[1, 4]
        )
        mode.q += sixth * (whole_q * force + 4.0 * half_q * middle)
        mode.v += sixth * (whole_v * force + 4.0 * half_v * middle + end)
        force = end


@inlined
def _breaks(arm: Record, begin: float, duration: float) -> bool:
    """Whether a law begins or ends within a duration, or at its end."""
    end = begin + duration
    for row in range(arm.laws):
        law = nth(arm.law, row)
        if begin < law.begin <= end or begin < law.onset <= end:
            return True
    return False


@inlined
def _joint_after(
    arm: Record, theta: float, omega: float, early: float, late: float, t: float
) -> tuple[float, float]:
    """The joint's angle and rate a time after a cycle's start, from the theta'' that its two parts begin with."""
    first = min(t, arm.early)
    theta, omega = theta + way(omega, arm.decay, early, first), omega + early * risen(arm.decay, first)
    then = t - first
    return theta + way(omega, arm.decay, late, then), omega + late * risen(arm.decay, then)


@inlined
def _is_smooth(arm: Record, i: int, begin: float, duration: float) -> bool:
    """Whether no law begins or ends in a block, and a mode's frequency changes as a parabola through its values at the
    block's ends and middle."""
    if _breaks(arm, begin, duration):
        return False
    before, middle = ratio_at(arm, i, begin), ratio_at(arm, i, begin + 0.5 * duration)
    after, third = ratio_at(arm, i, begin + duration), ratio_at(arm, i, begin + _A_THIRD * duration)
    return abs(third - _parabola(before, middle, after, _A_THIRD)) < _SMOOTH


@inlined
def _parabola(before: float, middle: float, after: float, x: float) -> float:
    """The parabola through values at 0, 1/2 and 1."""
    return before + x * (4.0 * middle - 3.0 * before - after + 2.0 * x * (before + after - 2.0 * middle))


@inlined
def _by_matrix(mode: Record, matrices: Array, x: float, early: float, late: float) -> None:
    """A cycle of a mode by the matrix of that place in its block."""
    first = 1.0 - x * (3.0 - 2.0 * x)
    second, third = 4.0 * x * (1.0 - x), x * (2.0 * x - 1.0)
    q, v = mode.q, mode.v
    to_q, to_v = 0.0, 0.0
    for column in range(5):
        by = (
            q
            if column == 0
            else (v if column == 1 else (early if column == 2 else late if column == 3 else 1.0))
        )
        to_q += by * (
            first * matrices[0, 0, column] + second * matrices[1, 0, column] + third * matrices[2, 0, column]
        )
        to_v += by * (
            first * matrices[0, 1, column] + second * matrices[1, 1, column] + third * matrices[2, 1, column]
        )
    mode.q, mode.v = to_q, to_v


@inlined
def _by_stepper(arm: Record, i: int, t: float, theta: float, omega: float, early: float, late: float) -> None:
    """A cycle of a mode by the stepper, from the joint's state and the theta'' that its two parts begin with."""
    x, stretch = 0.0, arm.stretch
    for part in range(2):
        duration = arm.late if part == 1 else arm.early
        risen = arm.late_risen if part == 1 else arm.early_risen
        if duration <= 0.0:
            continue
        start = late if part == 1 else early
        passed, rise, end = lagging(omega, arm.decay, start, duration, risen)
        stretch.duration, stretch.decay, stretch.start, stretch.end = duration, arm.decay, start, end
        stretch.jump, stretch.theta, stretch.omega = 0.0, theta, omega
        by_laws(arm, i, t + x, x, stretch)
        theta, omega, x = theta + passed, omega + rise, x + duration
