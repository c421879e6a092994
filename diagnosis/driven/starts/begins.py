"""From modes that a subspace fit sees to the numbers of a grey box, and which of many begins are worth a whole fit."""

from collections.abc import Iterable, Iterator
from math import log

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from stillarm.diagnosis.driven.fitting.fitting import DrivenFit, fit
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.recording.regression import joint_motion, resonance, width_of
from stillarm.diagnosis.driven.recording.signals import Driven
from stillarm.diagnosis.driven.starts.subspace import SeenMode, modes_seen

Array = NDArray[np.float64]
Numbers = dict[str, float]

_SAME_W, _SAME_CARRIED = 0.02, 0.25  # of the larger: two sets of modes that begin one fit
_MOST_SETS = 9  # of modes that a fit begins from: each costs a look
_DAMPINGS = (8.0, 30.0, 100.0)  # 1/s: a joint that stops within 0.1 s to 0.01 s
_LOOK = 2  # steps of a fit, after which a begin shows what it is worth


def seen_begins(driven: Driven, numbers: Numbers, count: int) -> Iterator[Numbers]:
    """Numbers with `count` modes as a subspace fit sees them."""
    found: list[tuple[SeenMode, ...]] = []
    for modes in modes_seen(driven, count):
        if not any(_alike(modes, other) for other in found):
            found.append(modes)
    for modes in found[:_MOST_SETS]:
        yield with_modes(driven, numbers, modes)


def with_modes(driven: Driven, numbers: Numbers, modes: tuple[SeenMode, ...]) -> Numbers:
    """Numbers with these modes: the joint's own are regressed beside them, and what each sensor sees of each.

    A mode answers to theta'' at its clamped-free frequency; where no sensor looks at the joint, to the input at that
    of its free hub.
    """
    h, motion = driven.step_s, joint_motion(driven)
    force = numbers["gain"] * (driven.u - driven.u.mean()) if motion is None else motion[2]
    own = [m.w * np.sqrt(1.0 + m.carries) if motion is None else m.w for m in modes]
    answers = [resonance(force, w, m.zeta, h) for w, m in zip(own, modes, strict=True)]
    rates = [np.gradient(one, h) for one in answers]
    new = dict(numbers)
    for i, m in enumerate(modes, 1):
        new |= {f"log_w_{i}": log(m.w), f"zeta_{i}": m.zeta, f"carries_{i}": m.carries, f"follows_{i}": 1.0}
    if motion is not None:
        width = width_of(h)
        arm = -sum(
            m.carries * (m.w**2 * q + 2.0 * m.zeta * m.w * v)
            for m, q, v in zip(modes, answers, rates, strict=True)
        )
        columns = np.column_stack([savgol_filter(driven.u, width, 3), -motion[1], np.ones(driven.samples)])
        factor = _regressed(columns, motion[2] - arm)
        new |= {"gain": float(factor[0]), "damping": max(float(factor[1]), 0.0)}
    bends = [one for one in driven.outputs if one.kind == "deflection"]
    if bends:
        factor = _regressed(np.column_stack([*answers, np.ones(driven.samples)]), bends[0].values)
        new |= {f"follows_{i}": _not_zero(-float(factor[i - 1])) for i in range(1, len(modes) + 1)}
    for one in driven.outputs:
        new.setdefault(f"offset {one.name}", 0.0)
        if one.kind == "acceleration":
            bent = [
                force - 2.0 * m.zeta * w * v - w * w * q
                for m, w, q, v in zip(modes, own, answers, rates, strict=True)
            ]
            factor = _regressed(np.column_stack([force, np.ones(driven.samples), *bent]), one.values)
            new[f"direct {one.name}"] = float(factor[0])
            for i in range(1, len(modes) + 1):
                new[f"share_{i} {one.name}"] = -float(factor[1 + i]) / new[f"follows_{i}"]
    return new


def damped_joints(driven: Driven, numbers: Numbers) -> Iterator[Numbers]:
    """Numbers of a joint with its speed for a steady input, and more damping than a regression finds.

    Behind a high gear nearly all torque goes into damping: input and velocity are then alike, and their noise makes the
    regressed gain and damping too small by the same factor. A simulation knows better, where it begins there.
    """
    motion = joint_motion(driven)
    if motion is None:
        return
    omega, u = motion[1], driven.u - driven.u.mean()
    speed = float(omega @ u) / max(float(u @ u), 1e-300)
    for damping in _DAMPINGS:
        if damping > numbers["damping"] and speed != 0.0:
            yield {**numbers, "gain": speed * damping, "damping": damping}


def on_a_damped_joint(begin: Numbers, joint: Numbers) -> Numbers:
    """A begin with one mode, on a joint that was fitted with a rigid arm: its hub alone is lighter."""
    lighter = 1.0 + begin["carries_1"]
    return {**begin, "gain": joint["gain"] * lighter, "damping": joint["damping"] * lighter}


def best_begins(
    box: GreyBox, begins: Iterable[Numbers], free: tuple[str, ...], states: Array | None, keep: int
) -> list[DrivenFit]:
    """The best few after a look at each."""
    looked = [fit(box, one, free, states, steps=_LOOK) for one in begins]
    return sorted(looked, key=lambda one: -float(one.whole.sum()))[:keep]


def _regressed(columns: Array, wanted: Array) -> Array:
    known = np.isfinite(wanted)
    size = np.maximum(np.max(np.abs(columns), axis=0), 1e-300)
    return np.asarray(np.linalg.lstsq(columns[known] / size, wanted[known], rcond=1e-6)[0] / size)


def _not_zero(value: float) -> float:
    return value if value != 0.0 else 1e-3


def _alike(one: tuple[SeenMode, ...], other: tuple[SeenMode, ...]) -> bool:
    return all(
        abs(log(a.w / b.w)) < _SAME_W and abs(log(a.carries / b.carries)) < _SAME_CARRIED
        for a, b in zip(one, other, strict=True)
    )
