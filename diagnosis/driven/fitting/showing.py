"""What the sensors show of a simulation, in their deviations, as stacked: all that a fit's steps ask of one."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.driven.greybox.greybox import PARTS_OF_PLAY, Geared, GreyBox, Steps, on_motor
from stillarm.diagnosis.driven.greybox.input_path import before_and_after
from stillarm.diagnosis.driven.greybox.laws import Numbers
from stillarm.diagnosis.driven.greybox.play_side_by_side import play_side_by_side
from stillarm.diagnosis.driven.greybox.sensing import (
    is_late,
    jump_shown,
    shown_late,
    slope_weights_of,
    weights_of,
)
from stillarm.diagnosis.driven.greybox.side_by_side import is_linear, run_side_by_side
from stillarm.diagnosis.driven.recording.own import numbers_in
from stillarm.simulation.arm.torque_joint import laws_of

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
    if box.play:
        return _shown_with_play(box, numbers, states, sigma, late)
    if numbers.get("inertia_step", 0.0) != 0.0:
        outputs = box.run(numbers, states).outputs
        return box.stack.of([outputs[one.name] / sigma[one.name] for one in box.driven.outputs])
    steps = box.steps_of(numbers)
    u = box.driving(numbers, box.substeps)
    if late:
        return _shown_late(box, numbers, states, sigma, steps, u)
    found = np.empty(len(box.driven.outputs) * box.driven.samples)
    by_state, by_force = _weights(box, numbers, sigma, steps)
    _run(box, steps, u, states, by_state, by_force, box.stack.places, found)
    found = _with_less_of_jumps(box, numbers, by_force[:, 0], u, found)
    return _with_offsets(box, numbers, sigma, found)


def free_runs(box: GreyBox, numbers: Numbers, sigma: dict[str, float]) -> Array | None:
    """What the sensors show of each component of a block's state, of one that begins at 1 without any input, in
    deviations: (size, outputs, samples of the longest block). None where more than that tells of a state."""
    numbers = {**box.declared, **numbers}
    late = any(is_late(one, numbers) for one in box.driven.outputs)
    if box.driven.joins or box.play or late or numbers.get("inertia_step", 0.0) != 0.0:
        return None
    steps = box.steps_of(numbers)
    if not is_linear(steps.laws[0]):
        return None
    size, outputs, longest = box.size, len(box.driven.outputs), int(np.max(np.diff(box.starts)))
    by_state, by_force = _weights(box, numbers, sigma, steps)
    found, still = np.empty((size, outputs, longest)), np.zeros((size * longest * box.substeps, 2))
    places = longest * (np.arange(outputs)[:, None] + outputs * np.arange(size))
    run_side_by_side(
        steps.phi[0], steps.g[0], steps.laws[0], still, box.substeps, box.driven.step_s / box.substeps,
        longest * np.arange(size + 1), np.eye(size), by_state, by_force, places, found.ravel(),
    )  # fmt: skip
    return found


def _with_less_of_jumps(box: GreyBox, numbers: Numbers, by_input: Array, u: Array, found: Array) -> Array:
    """Without what the sensors do not show of the input's jumps. by_input: what each shows of the input just after."""
    lacks = by_input * [1.0 - jump_shown(one, numbers) for one in box.driven.outputs]
    if not lacks.any():
        return found
    before, after = before_and_after(u, box.substeps)
    return found - box.stack.of([one * (after - before) for one in lacks])


def _weights(box: GreyBox, numbers: Numbers, sigma: dict[str, float], steps: Steps) -> tuple[Array, Array]:
    """What each sensor shows of state and forces, where none is late."""
    rows = [weights_of(one, numbers, steps.linear) for one in box.driven.outputs]
    return _in_deviations(box, numbers, sigma, rows)


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


def _shown_with_play(
    box: GreyBox, numbers: Numbers, states: Array, sigma: dict[str, float], late: bool
) -> Array:
    """Where motor and link are two."""
    outputs, geared = box.driven.outputs, box.geared(numbers)
    by_motor = [on_motor(one, numbers) for one in outputs]
    rows = [
        _of_both(*weights_of(one, numbers, geared.link), on)
        for one, on in zip(outputs, by_motor, strict=True)
    ]
    if not late:
        found = np.empty(len(rows) * box.driven.samples)
        _play(
            box, numbers, geared, states, *_in_deviations(box, numbers, sigma, rows), box.stack.places, found
        )
        return _with_offsets(box, numbers, sigma, found)
    rows += [
        _of_both(*slope_weights_of(one, geared.link), on) for one, on in zip(outputs, by_motor, strict=True)
    ]
    series, places = _series(len(rows), box.driven.samples, box.starts)
    by_both, by_contact = (np.array(one) for one in zip(*rows, strict=True))
    _play(box, numbers, geared, states, by_both, by_contact, places, series.ravel())
    for one, on, rate, slope in zip(outputs, by_motor, series, series[len(outputs) :], strict=False):
        if on and one.kind == "velocity":  # what pushes the motor is no sum of its state
            slope[:] = np.gradient(rate, box.driven.step_s)
    return _told_late(box, numbers, sigma, series, [0.0] * len(outputs), np.zeros(box.driven.samples - 1))


def _of_both(by_state: Array, by_force: Array, on: bool) -> tuple[Array, Array]:
    """What a sensor shows of link and motor, and of the contact. on: an angle or a velocity is the motor's."""
    by_link, by_motor = (np.zeros_like(by_state), by_state[:2]) if on else (by_state, np.zeros(2))
    return np.concatenate([by_link, by_motor]), by_force[1:2]


def _play(
    box: GreyBox, numbers: Numbers, geared: Geared, states: Array, by_both: Array, by_contact: Array,
    places: NDArray[np.int64], out: Array,
) -> None:  # fmt: skip
    parts = box.substeps * PARTS_OF_PLAY
    play_side_by_side(
        geared.joint, laws_of(numbers), geared.phi, geared.held, box.driving(numbers, parts), parts,
        box.driven.step_s / parts, box.starts, np.ascontiguousarray(states), by_both, by_contact.ravel(), places, out,
    )  # fmt: skip


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
    weights = [weights_of(one, numbers, steps.linear) for one in outputs]
    weights += [slope_weights_of(one, steps.linear) for one in outputs]
    series, places = _series(len(weights), box.driven.samples * many, box.starts * many)
    by_state, by_force = (np.array(one) for one in zip(*weights, strict=True))
    _run(box, steps, u, states, by_state, by_force, places, series.ravel())
    parts = box.substeps // many
    jumps = u[parts::parts, 0] - u[parts - 1 : -1 : parts, 1]
    return _told_late(box, numbers, sigma, series, [one[0] for _, one in weights], jumps)


def _series(count: int, rows: int, starts: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64]]:
    """Room for so many series, each of all blocks, and where in it each one's blocks begin."""
    return np.empty((count, rows)), rows * np.arange(count)[:, None] + starts[:-1]


def _told_late(
    box: GreyBox,
    numbers: Numbers,
    sigma: dict[str, float],
    series: Array,
    by_input: Sequence[float],
    jumps: Array,
) -> Array:
    """What the sensors show of the series at each step, the sensors' and then those of their slopes. by_input: what
    each shows of the input; jumps: by how much that jumps at each step but the first."""
    outputs = box.driven.outputs
    many = series.shape[1] // box.driven.samples
    starts, step_s = box.starts * many, box.driven.step_s / many
    told = []
    for one, after, slope, share in zip(outputs, series, series[len(outputs) :], by_input, strict=False):
        seen = after
        if is_late(one, numbers):
            sides, slopes = np.stack([after, after]), slope
            if one.kind == "acceleration":  # it jumps with the input, and its slope is that of what it shows
                sides[0, 1:] -= share * jumps
                slopes = np.gradient(after, step_s)
            seen = shown_late(one, numbers, sides, slopes, step_s, starts)
        elif jump_shown(one, numbers) != 1.0:
            seen = after.copy()
            seen[1:] -= (1.0 - jump_shown(one, numbers)) * share * jumps
        scale, offset = numbers.get(f"scale {one.name}", 1.0), numbers.get(f"offset {one.name}", 0.0)
        told.append((scale * seen[::many] + offset) / sigma[one.name])
    return box.stack.of(told)


__all__ = ["free_runs", "shown"]
