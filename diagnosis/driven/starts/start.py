"""A first model from the data alone: gain and damping of the joint, and the modes, as the recording shows them.

The joint's numbers come from a regression of its acceleration, band-limited by a local cubic, on input and velocity;
each mode from the frequency at which a resonance that the input drives explains most. What follows fits them.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import log, pi

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.driven.fitting.fitting import DrivenFit, fit
from stillarm.diagnosis.driven.fitting.freedom import free_of, has_joint, needs_mode
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.recording.regression import (
    joint_motion,
    joint_numbers,
    numbers_without_joint,
    resonance,
    width_of,
)
from stillarm.diagnosis.driven.recording.signals import Driven, Output
from stillarm.diagnosis.driven.starts.begins import best_begins, damped_joints, on_a_damped_joint, seen_begins
from stillarm.diagnosis.driven.starts.stated import Stated
from stillarm.diagnosis.driven.starts.stated_start import stated_start

Array = NDArray[np.float64]

_LOWEST_HZ, _TRIED_HZ = 0.4, 48  # from where; in so many equal ratios, of 1.16 at 1 kHz
_DAMPING_TRIED = 0.02  # ratio: where a mode's fit begins, the upper end of a usual arm's
_INERTIA_TRIED = (0.1, 1.0)  # of a mode, over the hub's: how much higher it rings on a free hub
_QUICK, _KEPT = 8, 3  # steps of a fit; fits that go on of those that a look has ranked
_SHARES_TRIED = (0.2, 0.6)  # of the motor in the inertia, where there is play


def linear_start(
    driven: Driven, split: Split, stated: Stated | None = None, declared: Mapping[str, float] | None = None
) -> DrivenFit:
    """The best linear start: a joint, with a mode where the arm is measured; or what the model states. The input is
    held or linear between samples, as foretells more. declared: numbers of causes that a model file has."""
    begun = _start(GreyBox(driven, split, declared=declared or {}), stated)
    other = {**begun.numbers, "held": 1.0 - begun.numbers.get("held", 0.0)}
    held = fit(begun.box, other, begun.free, begun.states)
    return max(begun, held, key=lambda one: float(one.whole.sum()))


def _start(plain: GreyBox, stated: Stated | None) -> DrivenFit:
    driven, declared = plain.driven, plain.declared
    if stated is not None:
        return stated_start(plain, stated)
    numbers = {**(joint_numbers(driven) if has_joint(driven) else numbers_without_joint(driven)), **declared}
    if "gap" in declared:
        return _start_with_play(plain, numbers)
    joint = plain.without_arm()
    damped = [{**one, **declared} for one in damped_joints(driven, numbers)] if has_joint(driven) else []
    if not needs_mode(driven):
        best = best_begins(plain, [numbers, *damped], free_of(plain), None, 1)[0]
        return fit(replace(plain, begun=best.numbers), best.numbers, best.free, best.states)
    box = replace(plain, modes=1)
    states = None
    if has_joint(driven):
        best = best_begins(joint, [numbers, *damped], free_of(joint), None, 1)[0]
        begun = fit(joint, best.numbers, best.free, best.states, steps=_QUICK)
        numbers, states = {**numbers, **begun.numbers}, begun.states
    own = [*regressed_modes(driven, numbers), *seen_begins(driven, numbers, 1)]
    begins = [*modes_to_try(plain, numbers, None), *own]
    if has_joint(driven):
        begins += [on_a_damped_joint(one, numbers) for one in own]
    looked = best_begins(box, ({**one, **declared} for one in begins), free_of(box), states, _KEPT)
    tried = [
        fit(replace(box, begun=one.numbers), one.numbers, one.free, one.states, steps=_QUICK)
        for one in looked
    ]
    best = max(tried, key=lambda one: float(one.whole.sum()))
    return fit(best.box, best.numbers, best.free, best.states, steps=20)


def _start_with_play(plain: GreyBox, numbers: dict[str, float]) -> DrivenFit:
    """With declared play, whose side and inertias the recording tells."""
    box = replace(plain, play=True, modes=0)
    tried = [
        fit(
            box,
            {**numbers, "share": share, "bounce": 0.3, "on_motor": on_motor},
            (*free_of(box), "share", "bounce"),
        )
        for share in _SHARES_TRIED
        for on_motor in (0.0, 1.0)
    ]
    return max(tried, key=lambda one: float(one.whole.sum()))


def regressed_modes(driven: Driven, numbers: dict[str, float]) -> Iterator[dict[str, float]]:
    """Numbers with the first mode as the measured joint shows it: a resonance driven by theta'' answers at its
    clamped-free frequency, whatever the joint rubs; then theta'' is regressed on input, velocity and mode."""
    motion = joint_motion(driven)
    bent = next((one for one in driven.outputs if one.kind == "deflection"), None)
    if motion is None or bent is None:
        return
    _, omega, alpha = motion
    known = np.isfinite(bent.values)
    q = np.interp(np.arange(driven.samples), np.flatnonzero(known), bent.values[known])
    h = driven.step_s
    width = width_of(h)
    u = savgol_filter(driven.u, width, 3)
    q_smooth, v_smooth = savgol_filter(q, width, 3), savgol_filter(q, width, 3, deriv=1, delta=h)
    tried = []
    for zeta in (0.005, 0.03, 0.15):
        tried += [(*one, zeta) for one in _resonances(driven, bent.values, bent, alpha, zeta)]
    for _, hz, response, zeta in sorted(tried, key=lambda one: -one[0])[:2]:
        w = 2.0 * pi * hz
        arm = w * w * (q_smooth - q_smooth.mean()) + 2.0 * zeta * w * v_smooth
        rubs = -np.tanh(omega / max(0.02 * float(np.max(np.abs(omega))), 1e-12))
        columns = np.column_stack([u, -omega, arm, np.ones_like(u), rubs])
        size = np.maximum(np.std(columns, axis=0), 1e-12)
        size[3] = 1.0
        factor = np.linalg.lstsq(columns / size, alpha, rcond=1e-4)[0] / size
        yield {
            **numbers,
            "gain": float(factor[0]),
            "damping": max(float(factor[1]), 0.0),
            "log_w_1": log(w),
            "zeta_1": zeta,
            "follows_1": -response,
            "carries_1": min(max(-float(factor[2]) * response, 0.02), 20.0),
        }


def with_another_mode(fitted: DrivenFit, least: float = 0.0) -> DrivenFit | None:
    """The same with the mode more that explains most of what is left; None where none can be. least: nats of a step,
    see `fit`."""
    box = replace(fitted.box, modes=fitted.box.modes + 1)
    extra = tuple(one for one in fitted.free if one not in free_of(fitted.box))
    begins = [
        *modes_to_try(fitted.box, fitted.numbers, fitted),
        *seen_begins(fitted.box.driven, fitted.numbers, box.modes),
    ]
    looked = best_begins(box, begins, free_of(box) + extra, _with_place(fitted), _KEPT)
    tried = [fit(box, one.numbers, one.free, one.states, steps=5) for one in looked]
    if not tried:
        return None
    best = max(tried, key=lambda one: float(one.whole.sum()))
    return fit(box, best.numbers, best.free, best.states, least=least)


def _with_place(fitted: DrivenFit) -> Array:
    """The blocks' states with zeros for a further mode, before the motor's own where there is play."""
    if not fitted.box.play:
        return fitted.states
    link, motor = fitted.states[:, :-2], fitted.states[:, -2:]
    return np.concatenate([link, np.zeros_like(motor), motor], axis=1)


def modes_to_try(
    box: GreyBox, numbers: dict[str, float], fitted: DrivenFit | None
) -> Iterator[dict[str, float]]:
    """Numbers with one mode more, at the frequencies that explain most."""
    i, driven = box.modes + 1, box.driven
    output = _looks_at_arm(driven)
    residual = output.values if fitted is None else fitted.residuals[output.name]
    bends = output.kind == "deflection"
    ranked = sorted(_resonances(driven, residual, output, driven.u), key=lambda one: -one[0])[
        : 2 if fitted is None else 3
    ]
    shares = _INERTIA_TRIED if has_joint(driven) else (0.05,)
    for _, hz, response in ranked:
        for share in shares:
            w = 2.0 * pi * hz / np.sqrt(1.0 + share)
            follows = -response / numbers["gain"] if bends else 1.0
            new = {
                **numbers,
                f"log_w_{i}": log(w),
                f"zeta_{i}": _DAMPING_TRIED,
                f"follows_{i}": follows if follows != 0.0 else 1e-3,
                f"carries_{i}": share,
            }
            for one in driven.outputs:
                if one.kind == "acceleration":
                    new.setdefault(f"direct {one.name}", 0.0)
                    new[f"share_{i} {one.name}"] = -response / numbers["gain"]
                new.setdefault(f"offset {one.name}", 0.0)
            yield new


def _looks_at_arm(driven: Driven) -> Output:
    order = ("deflection", "acceleration", "velocity", "position", "motor")
    return min(driven.outputs, key=lambda one: order.index(one.kind))


def _resonances(
    driven: Driven, residual: Array, output: Output, force: Array, zeta: float = _DAMPING_TRIED
) -> list[tuple[float, float, float]]:
    """(share of the variance, Hz, response): of a resonance q'' = -w^2 q - 2 zeta w q' + response * force, or what this
    sensor makes of one."""
    h = driven.step_s
    known = np.isfinite(residual)
    u = force - force.mean()
    highest = 0.4 / h
    found = []
    total = float(np.var(residual[known])) + 1e-300
    for hz in np.geomspace(max(_LOWEST_HZ, 2.0 / driven.duration_s), highest, _TRIED_HZ):
        w = 2.0 * pi * hz
        x = resonance(u, w, zeta, h)
        if output.kind == "velocity":
            x = np.gradient(x, h)
        elif output.kind == "acceleration":
            x = u - 2.0 * zeta * w * np.gradient(x, h) - w * w * x
        columns = np.column_stack([x[known], np.gradient(x, h)[known] / w, np.ones(known.sum())])
        factor, *_ = np.linalg.lstsq(columns, residual[known], rcond=None)
        left = float(np.var(residual[known] - columns @ factor))
        found.append((1.0 - left / total, float(hz), float(factor[0])))
    peaks = [
        one for k, one in enumerate(found)
        if one[0] >= max(other[0] for other in found[max(k - 1, 0) : k + 2])
    ]  # fmt: skip
    return peaks
