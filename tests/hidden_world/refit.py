"""The baseline refitted to the end: Gauss-Newton, linearised anew on the way, from where the arm's ringing points.

An effect that makes the arm ring at another pitch (creep, hysteresis, a stiffness that grows) lies many turns of phase
from the baseline that knows nothing of it; what one linearisation leaves there says nothing of what a refit leaves.
"""

from dataclasses import replace
from itertools import pairwise
from math import log, pi

import numpy as np
from numpy.typing import NDArray

from tests.hidden_world.baseline import Baseline, vector_of
from tests.hidden_world.effects import CAUSES, Effect
from tests.hidden_world.motion import WIDTH
from tests.hidden_world.rig import TICK_S
from tests.hidden_world.world import Case, Open, moved

Array = NDArray[np.float64]

_ROUNDS = 8
_RING_S = 6.0
_SETTLED = 0.01
_NEXT_TO_NOTHING = 3.0


def detunes(effect: Effect) -> bool:
    """Whether an effect may bring a refit far from where it starts."""
    own = ("bouc_wen_hysteresis", "asymmetric_stiffness", "viscoelastic_creep")
    return effect.name in own or (effect.name in CAUSES and CAUSES[effect.name].where == "arm")


def refitted_nats(case: Case, there: Array, base: Baseline) -> float:
    """Half the squared norm of what the best baseline leaves of `there`, the whitened case."""
    starts = (np.zeros(len(base.free)), _ringing(case, base))
    near = [(0.5 * float(np.sum((there - vector_of(base, steps)) ** 2)), steps) for steps in starts]
    cost, steps = min(near, key=lambda start: start[0])
    now = vector_of(base, steps)
    for _ in range(_ROUNDS):
        before = cost
        jacobian = np.stack([vector_of(base, steps + one) - now for one in np.eye(len(steps))], axis=1)
        scale = np.maximum(np.linalg.norm(jacobian, axis=0), 1e-12)
        basis, into = np.linalg.qr(jacobian / scale)
        for share in (1.0, 1.0, 1.0, 0.3, 0.1):  # the same linearisation, while it serves
            step = np.linalg.lstsq(into, basis.T @ (there - now), rcond=1e-9)[0] / scale
            vector = vector_of(base, steps + share * step)
            left = 0.5 * float(np.sum((there - vector) ** 2))
            if left > (1.0 - _SETTLED) * cost:
                if cost < before:
                    break
                continue
            steps, now, cost = steps + share * step, vector, left
        if cost > (1.0 - _SETTLED) * before or cost < _NEXT_TO_NOTHING:
            break
    return cost


def _ringing(case: Case, base: Baseline) -> Array:
    """Steps of the first bend's pitch and loss to those at which the case rings down by itself."""
    steps = np.zeros(len(base.free))
    names = [one.name for one in base.free]
    hertz, loss = _rung(case)
    bare_hertz, bare_loss = _rung(base.case)
    at = names.index("hertz_0")
    steps[at] = (hertz / bare_hertz - 1.0) / base.free[at].step
    at = names.index("loss_0")
    steps[at] = max(loss - bare_loss, -0.9 * base.case.rig.bends[0].loss) / base.free[at].step
    return steps


def _rung(case: Case) -> tuple[float, float]:
    """Hz and damping ratio of a free ring-down from half a usual bending."""
    alone = replace(case, duration_s=_RING_S, impacts=False, damped=False)
    cycles = round(_RING_S / TICK_S)
    start = np.zeros(WIDTH)
    start[2] = 0.5 * case.scale_m
    bend = moved(alone, Open(start=start, command=np.zeros(cycles))).rows[:, 2]
    bend = bend - moved(alone, Open(command=np.zeros(cycles))).rows[:, 2]
    up = np.flatnonzero((bend[:-1] < 0.0) & (bend[1:] >= 0.0))
    if len(up) < 3:
        return case.rig.bends[0].hertz, case.rig.bends[0].loss
    step_s = _RING_S / (len(bend) - 1)
    crossing = (up - bend[up] / (bend[up + 1] - bend[up])) * step_s
    hertz = (len(crossing) - 1) / float(crossing[-1] - crossing[0])
    peaks = [float(np.max(bend[a:b])) for a, b in pairwise(up)]
    if len(peaks) < 2 or min(peaks[0], peaks[-1]) <= 0.0:
        return hertz, case.rig.bends[0].loss
    return hertz, log(peaks[0] / peaks[-1]) / (2.0 * pi * (len(peaks) - 1))
