"""Blocks of a joint with play simulated side by side, for what the sensors show alone.

The equations of motion are those of stillarm.simulation.arm.geared_joint, and its numbers come out to the last bit; see
side_by_side.py for why there are two.
"""

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.driven import side_by_side
from stillarm.diagnosis.driven.side_by_side import begin_group, laws_on, many_beside
from stillarm.simulation.arm.compiler import compiled_from
from stillarm.simulation.arm.torque_joint import friction_limits, smooth_torque

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


def play_side_by_side(
    joint: tuple[float, float, float, float, float], law: Array, phi: Array, g: Array, u: Array, substeps: int,
    step_s: float, starts: Integers, states: Array, by_state: Array, by_contact: Array, places: Integers, out: Array,
) -> None:  # fmt: skip
    """Free runs over all blocks, as `run_side_by_side`. joint: share, gain, damping, gap and bounce of `play_run`; phi:
    (n, n), g: (n,) of the link over a substep. by_state: (m, n + 2), by_contact: (m,), what each sensor shows of link
    and motor, and of the contact's force on the link just after a sample."""
    beside = many_beside(len(starts) - 1)
    _run(
        *joint, law, *laws_on(law), phi, g, beside, u, substeps, step_s, starts, states, by_state, by_contact, places,
        out,
    )  # fmt: skip


@compiled_from(__file__, side_by_side.__file__)
def _run(  # noqa: PLR0912 (in one loop, as each call inside it would cost as much as its body)
    share: float, gain: float, damping: float, gap: float, bounce: float, law: Array, pushes: bool, rubs: bool,
    phi: Array, g: Array, beside: int, u: Array, substeps: int, step_s: float, starts: Integers, states: Array,
    by_state: Array, by_contact: Array, places: Integers, out: Array,
) -> None:  # fmt: skip
    h, n, m, blocks = step_s, len(g), by_state.shape[0], len(starts) - 1
    z, new, shown = np.zeros((n, beside)), np.zeros((n, beside)), np.zeros(beside)
    motor, rate, touch = np.zeros(beside), np.zeros(beside), np.zeros(beside)
    before, before_rate = np.zeros(beside), np.zeros(beside)
    first, length = np.zeros(beside, np.int64), np.zeros(beside, np.int64)
    yields, light = g[1] / (1.0 - share), h / share  # of link and motor, to the contact's force over a step
    for group in range(0, blocks, beside):
        longest = begin_group(group, starts, states, z, first, length)
        for b in range(beside):
            block = min(group + b, blocks - 1)
            motor[b], rate[b] = states[block, n], states[block, n + 1]
        here = min(beside, blocks - group)
        for k in range(longest):
            for s in range(substeps):
                for i in range(n):
                    for b in range(beside):
                        new[i, b] = 0.0
                    for j in range(0, n, 2):
                        for b in range(beside):
                            new[i, b] = (new[i, b] + phi[i, j] * z[j, b]) + phi[i, j + 1] * z[j + 1, b]
                for b in range(beside):
                    at = (first[b] + min(k, length[b] - 1)) * substeps + s
                    before[b], before_rate[b] = motor[b], rate[b]
                    push = 0.5 * gain * (u[at, 0] + u[at, 1]) - damping * rate[b]
                    if pushes:
                        push += smooth_torque(law, motor[b] + 0.5 * h * rate[b], rate[b])
                    forward, backward = 0.0, 0.0
                    if rubs:
                        forward, backward = friction_limits(law, rate[b])
                    pushed, contact, rub = rate[b] + light * push, 0.0, 0.0
                    meets = rate[b] - z[1, b]
                    ahead = motor[b] - z[0, b] + h * meets
                    if ahead >= 0.5 * gap or ahead <= -0.5 * gap:
                        parts = bounce * (max(meets, 0.0) if ahead > 0.0 else min(meets, 0.0))
                        rub = min(max(-pushed / light - new[1, b] / yields, -forward), backward)
                        contact = (pushed + light * rub - new[1, b] + parts) / (light + yields)
                        if (ahead > 0.0) != (contact >= 0.0):  # it lets go
                            contact = 0.0
                    if contact == 0.0:
                        rub = min(max(-pushed / light, -forward), backward)
                    new_rate = pushed + light * (rub - contact)
                    motor[b] += 0.5 * h * (rate[b] + new_rate)
                    rate[b], touch[b] = new_rate, contact / (1.0 - share)
                if s == 0:
                    for o in range(m):
                        for b in range(beside):
                            shown[b] = by_contact[o] * touch[b]
                            shown[b] += by_state[o, n] * before[b] + by_state[o, n + 1] * before_rate[b]
                        for j in range(n):
                            for b in range(beside):
                                shown[b] += by_state[o, j] * z[j, b]
                        for b in range(here):
                            if k < length[b]:
                                out[places[o, group + b] + k] = shown[b]
                for i in range(n):
                    for b in range(beside):
                        z[i, b] = new[i, b] + g[i] * touch[b]
                for b in range(beside):
                    apart = motor[b] - z[0, b]
                    over = abs(apart) - 0.5 * gap
                    if over > 0.0:
                        z[0, b] += np.sign(apart) * over


__all__ = ["play_side_by_side"]
