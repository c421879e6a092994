"""Blocks of a joint with play simulated side by side, for what the sensors show alone.

The equations of motion are those of stillarm.simulation.arm.geared_joint. See side_by_side.py for why there are two,
and how the loops are laid out: nothing in them branches, so what does not hold is worked out and thrown away.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.driven.greybox import side_by_side, vectorised
from stillarm.diagnosis.driven.greybox.side_by_side import (
    BACKWARD,
    BESIDE,
    FORWARD,
    PUSH,
    SHOWN,
    STATE,
    advance,
    begin_group,
    laws_on,
    limit_friction,
    push_joint,
    show,
)
from stillarm.simulation.arm import torque_joint
from stillarm.simulation.arm.compiler import compiled_from, inlined

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

_DRIVES, _TOUCH, _MOTOR, _RATE, _BEFORE = range(4, 9)


def play_side_by_side(
    joint: tuple[float, float, float, float, float], law: Array, phi: Array, g: Array, u: Array, substeps: int,
    step_s: float, starts: Integers, states: Array, by_state: Array, by_contact: Array, places: Integers, out: Array,
) -> None:  # fmt: skip
    """Free runs over all blocks, as `run_side_by_side`. joint: share, gain, damping, gap and bounce of `play_run`; phi:
    (n, n), g: (n,) of the link over a substep. by_state: (m, n + 2), by_contact: (m,), what each sensor shows of link
    and motor, and of the contact's force on the link just after a sample."""
    stepper = _stepper_of(len(phi))
    stepper(
        joint, law, *laws_on(law), phi, g, u, substeps, step_s, starts, states, by_state, by_contact, places, out
    )  # fmt: skip


@cache
def _stepper_of(n: int) -> Callable[..., None]:
    """Compiled for links of so many components."""

    @compiled_from(__file__, side_by_side.__file__, torque_joint.__file__, vectorised.__file__)
    def stepper(
        joint: tuple[float, float, float, float, float], law: Array, pushes: bool, rubs: bool, phi: Array, g: Array,
        u: Array, substeps: int, step_s: float, starts: Integers, states: Array, by_state: Array, by_contact: Array,
        places: Integers, out: Array,
    ) -> None:  # fmt: skip
        gain = joint[1]
        blocks, was = len(starts) - 1, STATE + 2 * n + 2  # where the motor's velocity before a step is
        work = np.zeros((was + 1) * BESIDE)
        first, length = np.zeros(BESIDE, np.int64), np.zeros(BESIDE, np.int64)
        row = np.zeros(BESIDE, np.int64)
        for group in range(0, blocks, BESIDE):
            longest = begin_group(group, starts, states, work, first, length)
            many = min(BESIDE, blocks - group)
            for b in range(BESIDE):
                work[_MOTOR * BESIDE + b] = work[(STATE + n) * BESIDE + b]
                work[_RATE * BESIDE + b] = work[(STATE + n + 1) * BESIDE + b]
            for k in range(longest):
                for b in range(BESIDE):
                    row[b] = (first[b] + min(k, length[b] - 1)) * substeps
                    work[_BEFORE * BESIDE + b] = work[_MOTOR * BESIDE + b]
                    work[was * BESIDE + b] = work[_RATE * BESIDE + b]
                for s in range(substeps):
                    for b in range(BESIDE):
                        work[_DRIVES * BESIDE + b] = 0.5 * gain * (u[row[b] + s, 0] + u[row[b] + s, 1])
                    advance(n, phi, work)
                    if pushes:
                        push_joint(law, step_s, work, _MOTOR, _RATE)
                    if rubs:
                        limit_friction(law, work, _RATE)
                    _meet(n, joint, g[1], step_s, work)
                    if s == 0:
                        for o in range(len(by_state)):
                            for b in range(BESIDE):
                                work[SHOWN * BESIDE + b] = (
                                    by_contact[o] * work[_TOUCH * BESIDE + b]
                                    + by_state[o, n] * work[_BEFORE * BESIDE + b]
                                    + by_state[o, n + 1] * work[was * BESIDE + b]
                                )
                            show(o, n, many, by_state, work, k, length, places[:, group:], out)
                    _take_along(n, joint[3], g, work)

    return stepper


@inlined
def _meet(
    n: int, joint: tuple[float, float, float, float, float], reached: float, h: float, work: Array
) -> None:
    """Move the motor by a step h, and fill in the force of its contact on the link. reached: the link's velocity after
    a step with a force of 1."""
    share, _, damping, gap, bounce = joint
    # of link and motor, to the contact's force over a step
    yields, light = reached / (1.0 - share), h / share
    for b in range(BESIDE):
        motor, rate = work[_MOTOR * BESIDE + b], work[_RATE * BESIDE + b]
        next_rate = work[(STATE + n + 1) * BESIDE + b]
        forward, backward = work[FORWARD * BESIDE + b], work[BACKWARD * BESIDE + b]
        pushed = rate + light * (work[_DRIVES * BESIDE + b] - damping * rate + work[PUSH * BESIDE + b])
        meets = rate - work[(STATE + 1) * BESIDE + b]
        ahead = motor - work[STATE * BESIDE + b] + h * meets
        parts = bounce * (max(meets, 0.0) if ahead > 0.0 else min(meets, 0.0))
        rub = min(max(-pushed / light - next_rate / yields, -forward), backward)
        contact = (pushed + light * rub - next_rate + parts) / (light + yields)
        lets_go = (contact < 0.0) if ahead > 0.0 else (contact >= 0.0)
        contact = 0.0 if abs(ahead) < 0.5 * gap or lets_go else contact
        alone = min(max(-pushed / light, -forward), backward)
        new_rate = pushed + light * ((alone if contact == 0.0 else rub) - contact)
        work[_MOTOR * BESIDE + b] = motor + 0.5 * h * (rate + new_rate)
        work[_RATE * BESIDE + b], work[_TOUCH * BESIDE + b] = new_rate, contact / (1.0 - share)


@inlined
def _take_along(n: int, gap: float, g: Array, work: Array) -> None:
    """The link's state after a step, as far from the motor as the gap lets it."""
    for b in range(BESIDE):
        for i in range(n):
            work[(STATE + i) * BESIDE + b] = (
                work[(STATE + n + i) * BESIDE + b] + g[i] * work[_TOUCH * BESIDE + b]
            )
        apart = work[_MOTOR * BESIDE + b] - work[STATE * BESIDE + b]
        over = max(abs(apart) - 0.5 * gap, 0.0)
        work[STATE * BESIDE + b] += over if apart > 0.0 else -over


__all__ = ["play_side_by_side"]
