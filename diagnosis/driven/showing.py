"""What the sensors show of a simulation, in their deviations, as stacked: all that a fit's steps ask of one."""

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.driven.greybox import PARTS_OF_PLAY, GreyBox, Steps, on_motor
from stillarm.diagnosis.driven.laws import Numbers, laws_of
from stillarm.diagnosis.driven.own import numbers_in
from stillarm.diagnosis.driven.play_side_by_side import play_side_by_side
from stillarm.diagnosis.driven.sensing import is_late, shown_late, slope_weights_of, weights_of
from stillarm.diagnosis.driven.side_by_side import run_side_by_side

Array = NDArray[np.float64]


def shown(box: GreyBox, numbers: Numbers, states: Array, sigma: dict[str, float]) -> Array:
    """What the sensors show, in deviations, as stacked."""
    if box.driven.joins:
        each = [
            shown(one, numbers_in(numbers, k), np.ascontiguousarray(states[box.recording == k]), sigma)
            for k, one in enumerate(box.parts)
        ]
        return np.concatenate(each)
    numbers = {**box.declared, **numbers}
    late = any(is_late(one, numbers) for one in box.driven.outputs)
    if box.play and not late:
        return _shown_with_play(box, numbers, states, sigma)
    if box.play or numbers.get("inertia_step", 0.0) != 0.0:
        outputs = box.run(numbers, states).outputs
        return box.stack.of([outputs[one.name] / sigma[one.name] for one in box.driven.outputs])
    steps = box.steps_of(numbers)
    u = box.driving(numbers, box.substeps)
    if late:
        return _shown_late(box, numbers, states, sigma, steps, u)
    found = np.empty(len(box.driven.outputs) * box.driven.samples)
    by_state, by_force = _in_deviations(
        box, numbers, sigma, [weights_of(one, numbers, steps.linear) for one in box.driven.outputs]
    )
    _run(box, steps, u, states, by_state, by_force, box.stack.places, found)
    return _with_offsets(box, numbers, sigma, found)


def _in_deviations(
    box: GreyBox, numbers: Numbers, sigma: dict[str, float], rows: list[tuple[Array, Array]]
) -> tuple[Array, Array]:
    """What each sensor shows of state and forces, with its scale, in its deviations."""
    scales = [numbers.get(f"scale {one.name}", 1.0) / sigma[one.name] for one in box.driven.outputs]
    by_state = np.array([scale * row for scale, (row, _) in zip(scales, rows, strict=True)])
    return by_state, np.array([scale * row for scale, (_, row) in zip(scales, rows, strict=True)])


def _with_offsets(box: GreyBox, numbers: Numbers, sigma: dict[str, float], found: Array) -> Array:
    offsets = np.array(
        [numbers.get(f"offset {one.name}", 0.0) / sigma[one.name] for one in box.driven.outputs]
    )
    return found + offsets[box.stack.output] if offsets.any() else found


def _shown_with_play(box: GreyBox, numbers: Numbers, states: Array, sigma: dict[str, float]) -> Array:
    """Where motor and link are two, and no sensor is late."""
    geared = box.geared(numbers)
    parts = box.substeps * PARTS_OF_PLAY
    rows = []
    for one in box.driven.outputs:
        by_state, by_force = weights_of(one, numbers, geared.link)
        by_motor = np.zeros(2)
        if on_motor(one, numbers):  # it is an angle or a velocity
            by_motor, by_state[:2] = by_state[:2].copy(), 0.0
        rows.append((np.concatenate([by_state, by_motor]), by_force[1:2]))
    by_both, by_contact = _in_deviations(box, numbers, sigma, rows)
    found = np.empty(len(rows) * box.driven.samples)
    play_side_by_side(
        geared.joint, laws_of(numbers), geared.phi, geared.held, box.driving(numbers, parts), parts,
        box.driven.step_s / parts, box.starts, np.ascontiguousarray(states), by_both, by_contact.ravel(),
        box.stack.places, found,
    )  # fmt: skip
    return _with_offsets(box, numbers, sigma, found)


def _run(
    box: GreyBox, steps: Steps, u: Array, states: Array, by_state: Array, by_force: Array,
    places: NDArray[np.int64], out: Array,
) -> None:  # fmt: skip
    many = steps.seen_in
    run_side_by_side(
        steps.phi[0], steps.g[0], steps.laws[0], u, box.substeps // many, box.driven.step_s / box.substeps,
        box.starts * many, np.ascontiguousarray(states), by_state, by_force, places, out,
    )  # fmt: skip


def _shown_late(
    box: GreyBox, numbers: Numbers, states: Array, sigma: dict[str, float], steps: Steps, u: Array
) -> Array:
    """Sensors of which one is late, at least."""
    outputs, many = box.driven.outputs, steps.seen_in
    rows, starts = box.driven.samples * many, box.starts * many
    weights = [weights_of(one, numbers, steps.linear) for one in outputs]
    weights += [slope_weights_of(one, steps.linear) for one in outputs]
    found = np.empty(len(weights) * rows)
    places = rows * np.arange(len(weights))[:, None] + starts[:-1]
    _run(
        box,
        steps,
        u,
        states,
        np.array([c for c, _ in weights]),
        np.array([d for _, d in weights]),
        places,
        found,
    )
    series = found.reshape(len(weights), rows)
    parts, step_s = box.substeps // many, box.driven.step_s / many
    told = []
    for one, after, slope, (_, by_force) in zip(
        outputs, series, series[len(outputs) :], weights, strict=False
    ):
        sides, slopes = np.stack([after, after]), slope
        if one.kind == "acceleration":  # it jumps with the input, and its slope is that of what it shows
            sides[0, 1:] -= by_force[0] * (u[parts::parts, 0] - u[parts - 1 : -1 : parts, 1])
            slopes = np.gradient(after, step_s)
        late = is_late(one, numbers)
        seen = shown_late(one, numbers, sides, slopes, step_s, starts) if late else after
        scale, offset = numbers.get(f"scale {one.name}", 1.0), numbers.get(f"offset {one.name}", 0.0)
        told.append((scale * seen[::many] + offset) / sigma[one.name])
    return box.stack.of(told)


__all__ = ["shown"]
