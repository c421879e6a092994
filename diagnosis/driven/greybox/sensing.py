"""What the sensors of a rig make of its motion, step by step.

An acceleration jumps with a held input: at each step it has a value before and one after. A sensor that is late, or
slow against the steps, shows the one before; any other shows some of the jump in the sample that is taken as the input
changes ("jump NAME"): all of it where it is read just after, half of it where it averages over a short time about its
sample. Between steps all signals are taken for straight lines. So where a sensor
is late, steps are those of the simulation, however slow the samples.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.driven.greybox.laws import Numbers
from stillarm.diagnosis.driven.recording.signals import Output
from stillarm.simulation.arm.compiler import compiled_from
from stillarm.simulation.arm.torque_joint import LinearJoint

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


_FELT = np.array([1.0, 1.0, 0.0])  # of input and forces, by an accelerometer on the arm


@dataclass(frozen=True)
class Motion:
    """At each step: z, (n, 2 + 2 m), of joint and modes; forces, (n, 2), on joint and first mode. drive, theta_dd:
    (2, n), just before the step's input and just after, in the input's unit and rad/s^2."""

    linear: LinearJoint
    z: Array
    forces: Array
    drive: Array
    theta_dd: Array


def seen(output: Output, numbers: Numbers, motion: Motion, step_s: float, starts: NDArray[np.int64]) -> Array:
    """What a sensor shows, (n,). starts: first sample of each block, and the end."""
    name, z = output.name, motion.z
    scale, offset = numbers.get(f"scale {name}", 1.0), numbers.get(f"offset {name}", 0.0)
    if output.kind in ("position", "motor"):
        before, after, slope = z[:, 0], z[:, 0], z[:, 1]
    elif output.kind == "velocity":
        before, after, slope = z[:, 1], z[:, 1], motion.theta_dd[1]
    elif output.kind == "deflection":
        before = after = z[:, 2::2].sum(axis=1)
        slope = z[:, 3::2].sum(axis=1)
    else:
        before, after = _tip(name, numbers, motion, 0), _tip(name, numbers, motion, 1)
        slope = np.gradient(after, step_s)
        if not is_late(output, numbers):
            after = before + jump_shown(output, numbers) * (after - before)
    if is_late(output, numbers):
        after = shown_late(output, numbers, np.stack([before, after]), slope, step_s, starts)
    return np.asarray(scale * after + offset)


def shown_late(
    output: Output, numbers: Numbers, sides: Array, slope: Array, step_s: float, starts: NDArray[np.int64]
) -> Array:
    """What a late sensor shows, before its scale and offset. sides: (2, n), before and after each step's input."""
    name = output.name
    scale, offset = numbers.get(f"scale {name}", 1.0), numbers.get(f"offset {name}", 0.0)
    late_s, lag_s = numbers.get(f"delay {name}", 0.0), numbers.get(f"lag {name}", 0.0)
    told, many = np.full(len(starts) - 1, np.nan), sides.shape[1] // len(output.values)
    slow = lag_s > many * step_s  # it still shows what was before the block
    if (output.kind == "acceleration" or slow) and scale != 0.0:
        told = (output.values[starts[:-1] // many] - offset) / scale
    return _late(sides, slope, told, late_s, lag_s, step_s, starts)


def weights_of(output: Output, numbers: Numbers, linear: LinearJoint) -> tuple[Array, Array]:
    """What a sensor that is not late shows just after a step, before its scale and offset, as a sum: of the state,
    (n,), and of the input and the forces on joint and first mode, (3,)."""
    a, b = linear.equations()
    by_state, by_force = np.zeros(len(a)), np.zeros(3)
    if output.kind in ("position", "motor"):
        by_state[0] = 1.0
    elif output.kind == "velocity":
        by_state[1] = 1.0
    elif output.kind == "deflection":
        by_state[2::2] = 1.0
    else:
        direct = numbers.get(f"direct {output.name}", 0.0)
        by_state, by_force = direct * a[1], direct * b[1]
        for i, rate in enumerate(range(3, len(a), 2), 1):
            share = numbers.get(f"share_{i} {output.name}", 1.0)
            by_state, by_force = by_state + share * a[rate], by_force + share * b[rate] * _FELT
    return by_state, by_force


def slope_weights_of(output: Output, linear: LinearJoint) -> tuple[Array, Array]:
    """The same of its slope, of a sensor of motion that does not jump."""
    a, b = linear.equations()
    by_state, by_force = np.zeros(len(a)), np.zeros(3)
    if output.kind in ("position", "motor"):
        by_state[1] = 1.0
    elif output.kind == "velocity":
        by_state, by_force = a[1], b[1]
    else:
        by_state[3::2] = 1.0
    return by_state, by_force


def is_late(output: Output, numbers: Numbers) -> bool:
    """Whether a sensor shows what was, by a delay or a filter."""
    return numbers.get(f"delay {output.name}", 0.0) != 0.0 or numbers.get(f"lag {output.name}", 0.0) > 0.0


def jump_shown(output: Output, numbers: Numbers) -> float:
    """How much of an input's jump a sensor that is not late shows in the sample at which the input changes."""
    return numbers.get(f"jump {output.name}", 1.0) if output.kind == "acceleration" else 1.0


def _tip(name: str, numbers: Numbers, motion: Motion, side: int) -> Array:
    """An accelerometer's acceleration before (0) or after (1) each step's input."""
    a, b = motion.linear.equations()
    rates = np.arange(3, len(a), 2)
    bent = motion.z @ a[rates].T + np.outer(motion.drive[side], b[rates, 0])
    bent += np.outer(motion.forces[:, 0], b[rates, 1])
    shares = np.array([numbers.get(f"share_{i} {name}", 1.0) for i in range(1, len(rates) + 1)])
    return np.asarray(numbers.get(f"direct {name}", 0.0) * motion.theta_dd[side] + bent @ shares)


@compiled_from(__file__)
def _late(
    sides: Array, slope: Array, told: Array, late_s: float, lag_s: float, step_s: float, starts: Integers
) -> Array:
    """Each block's signal, delayed, and behind a lag of first order; steady in its slope before the block. sides:
    (2, n), before and after each step's input. told: what a filter shows where a block begins, as it may have been
    moved before it by more than a slope; NaN for a steady one."""
    shown = np.empty(sides.shape[1])
    for block in range(len(starts) - 1):
        a, b = starts[block], starts[block + 1]
        if b > a:
            if late_s != 0.0:
                _delay(sides[:, a:b], slope[a], slope[b - 1], late_s / step_s, step_s, shown[a:b])
            if lag_s > 1e-3 * step_s:
                one = np.stack((shown[a:b], shown[a:b])) if late_s != 0.0 else sides[:, a:b]
                begins = told[block] if np.isfinite(told[block]) else one[1, 0] - lag_s * slope[a]
                _lag(one, begins, lag_s, step_s, shown[a:b])
            elif late_s == 0.0:
                shown[a:b] = sides[1, a:b]
    return shown


@compiled_from(__file__)
def _delay(sides: Array, first: float, last: float, late: float, step_s: float, shown: Array) -> None:
    """Fill in a block's signal `late` steps before each step: on the line from after one step to before the next.
    first, last: its slope at either end."""
    count = sides.shape[1]
    for k in range(count):
        at = k - late
        place = int(min(max(np.floor(at), 0.0), max(count - 2.0, 0.0)))
        along = min(max(at - place, 0.0), 1.0)
        found = (1.0 - along) * sides[1, place] + along * sides[0, min(place + 1, count - 1)]
        shown[k] = found + step_s * (first * min(at, 0.0) + last * max(at - (count - 1), 0.0))


@compiled_from(__file__)
def _lag(sides: Array, begins: float, lag_s: float, step_s: float, shown: Array) -> None:
    """Fill in a block's signal behind a lag, exact for one that is linear from after one step to before the next."""
    keep = np.exp(-step_s / lag_s)
    end = 1.0 - lag_s / step_s * (1.0 - keep)
    begin = 1.0 - keep - end
    shown[0] = begins
    for k in range(1, sides.shape[1]):
        shown[k] = keep * shown[k - 1] + end * sides[0, k] + begin * sides[1, k - 1]


__all__ = ["Motion", "is_late", "jump_shown", "seen", "shown_late", "slope_weights_of", "weights_of"]
