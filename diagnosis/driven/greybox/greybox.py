"""The joint with its input and sensors as one simulation of named numbers: what is fitted, and what every cause is in.

The equations of motion are those of stillarm.simulation.arm.torque_joint. The input passes a dead zone, a limit, a
delay and a lag of first order on its way to the joint. Every number has a neutral value, at which it does nothing; a
cause is some of them set free. Scales that nobody knows are in `gain` (the input's) and in the arm's numbers (the
deflection's), so that an unknown unit asks for no number of its own.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import ceil, exp

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.driven.greybox.input_path import OF_INPUT, before_and_after, reaching
from stillarm.diagnosis.driven.greybox.laws import OF_JOINT, Numbers, pull_of
from stillarm.diagnosis.driven.greybox.sensing import Motion, is_late, seen
from stillarm.diagnosis.driven.recording.own import numbers_in
from stillarm.diagnosis.driven.recording.regression import joint_motion
from stillarm.diagnosis.driven.recording.signals import Driven, Output
from stillarm.diagnosis.driven.recording.stack import Stack
from stillarm.simulation.arm.geared_joint import link_of, play_run
from stillarm.simulation.arm.torque_joint import LinearJoint, laws_of, torque_run, transition

Array = NDArray[np.float64]

_LONGEST_STEP_S = 0.003  # of the simulation: a slower recording's samples are several
_MOST_ROOT = 1e4  # rad/s, 1.6 kHz: no mode is quicker, whatever a fit tries
PARTS_OF_PLAY = 4
"""Simulated steps with play for one without: an impact is right to a step."""
_REMEMBERED = 4  # inputs: those of a fit, of a number that is moved, and of a trial
_SIDES = {
    "position": "on_motor",
    "velocity": "rate_on_motor",
}  # numbers that tell on which side a sensor sits


@dataclass(frozen=True)
class Run:
    """outputs: by name, (n,). states: (n, 2 + 2 m); forces: (n, 2), see torque_run; drive: (n,) what reaches the joint,
    in the input's unit; acceleration: theta'', (n,)."""

    outputs: dict[str, Array]
    states: Array
    forces: Array
    drive: Array
    acceleration: Array


@dataclass(frozen=True)
class Steps:
    """phi: (2, n, n), g: (2, n, 4), laws: (2, l), see torque_run, before sample `switch` and from it on. seen_in: parts
    of a sample in which sensors look, several where one is late."""

    linear: LinearJoint
    phi: Array
    g: Array
    laws: Array
    switch: int
    seen_in: int


@dataclass(frozen=True)
class Geared:
    """joint: share, gain, damping, gap, bounce; phi: (n, n), held: (n,) of the link, see play_run."""

    joint: tuple[float, float, float, float, float]
    link: LinearJoint
    phi: Array
    held: Array


@dataclass(frozen=True)
class GreyBox:
    """A recording with the split by which it is judged: each block is a free run from a state of its own."""

    driven: Driven
    split: Split
    modes: int = 0
    play: bool = False
    """A motor and a link with play between them."""
    declared: Mapping[str, float] = field(default_factory=dict, hash=False)
    """Numbers that a model file declares: they hold where a fit has none of its own, and no baseline sets them free."""
    begun: Mapping[str, float] = field(default_factory=dict, hash=False)
    """Numbers from which the start's fit began: what is large draws that fit astray, and is then sought from here."""

    @cached_property
    def starts(self) -> NDArray[np.int64]:
        """First sample of each block, and the end."""
        edges = np.rint(self.split.edges_s / self.driven.step_s).astype(np.int64)
        edges[-1] = self.driven.samples
        return edges

    @cached_property
    def block(self) -> NDArray[np.int64]:
        """Number of each sample's block."""
        return np.repeat(np.arange(len(self.starts) - 1), np.diff(self.starts))

    @cached_property
    def stack(self) -> Stack:
        """How the samples of all outputs are stacked."""
        return Stack(self.driven.outputs, self.starts)

    @property
    def size(self) -> int:
        """Length of the state."""
        return 2 + 2 * self.modes + (2 if self.play else 0)

    @property
    def substeps(self) -> int:
        """Simulated steps a sample."""
        return max(1, ceil(self.driven.step_s / _LONGEST_STEP_S))

    def without_arm(self) -> "GreyBox":
        """The same, judged by the sensors at the joint alone."""
        return replace(
            self, driven=self.driven.with_outputs("position", "motor", "velocity"), modes=0, begun={}
        )

    def driving(self, numbers: Numbers, parts: int) -> Array:
        """What reaches the joint at the start and the end of each substep, (n parts, 2), in the input's unit.

        numbers["held"]: 1 where the input stays for a sample, as a converter holds it; 0 where it was measured and is
        linear between samples. What was asked for last is remembered: most numbers leave the input as it is.
        """
        key = parts, *(numbers.get(name, 0.0) for name in OF_INPUT)
        if key not in self._remembered:
            if len(self._remembered) >= _REMEMBERED:
                self._remembered.clear()
            self._remembered[key] = reaching(self.driven, numbers, parts)
        return self._remembered[key]

    @cached_property
    def _remembered(self) -> dict[tuple[float, ...], Array]:
        return {}

    def linear(self, numbers: Numbers, factor: float = 1.0) -> LinearJoint:
        """The linear part; factor: of the inertia that the hub shows."""
        factor *= 1.0 + numbers.get("inertia_excess", 0.0)
        modes = tuple(
            (
                exp(min(numbers[f"log_w_{i}"], np.log(_MOST_ROOT))),
                numbers[f"zeta_{i}"],
                numbers[f"follows_{i}"],
                pull_of(numbers, i) / factor,
            )
            for i in range(1, self.modes + 1)
        )
        return LinearJoint(
            numbers["gain"] / factor,
            numbers["damping"] / factor,
            numbers.get("stiffness", 0.0) / factor,
            modes,
        )

    @cached_property
    def parts(self) -> tuple["GreyBox", ...]:
        """The recordings each by itself, with the blocks that are theirs."""
        edges = np.array([0, *self.driven.joins, self.driven.samples])
        first = np.searchsorted(self.starts, edges)
        found = []
        for k in range(self.driven.recordings):
            a, b = first[k], first[k + 1]
            begins_s = edges[k] * self.driven.step_s
            split = Split(self.split.edges_s[a : b + 1] - begins_s, self.split.held[a:b])
            found.append(replace(self, driven=self.driven.part(k), split=split, begun={}))
        return tuple(found)

    @cached_property
    def recording(self) -> NDArray[np.int64]:
        """Number of each block's recording."""
        return np.repeat(np.arange(len(self.parts)), [len(one.split.held) for one in self.parts])

    def run(self, numbers: Numbers, states: Array) -> Run:
        """Simulate every block from its own state, (blocks, size)."""
        if self.driven.joins:
            return _joined(
                [
                    one.run(numbers_in(numbers, k), np.ascontiguousarray(states[self.recording == k]))
                    for k, one in enumerate(self.parts)
                ]
            )
        numbers = {**self.declared, **numbers}
        if self.play:
            return self._with_play(numbers, laws_of(numbers), states)
        driven, parts, steps = self.driven, self.substeps, self.steps_of(numbers)
        u, many = self.driving(numbers, parts), steps.seen_in
        rows, starts, h = driven.samples * many, self.starts * many, driven.step_s / parts
        out, forces = np.empty((rows, self.size)), np.empty((rows, 2))
        torque_run(
            steps.phi,
            steps.g,
            steps.laws,
            steps.switch * many,
            u,
            parts // many,
            h,
            starts,
            states,
            out,
            forces,
        )
        drive = before_and_after(u, parts // many)
        a, b = steps.linear.equations()
        theta_dd = out @ a[1] + b[1, 0] * drive + b[1, 1] * forces[:, 0] + b[1, 2] * forces[:, 1]
        motion = Motion(steps.linear, out, forces, drive, theta_dd)
        h = driven.step_s / many
        shown = {one.name: seen(one, numbers, motion, h, starts)[::many] for one in driven.outputs}
        return Run(shown, out[::many], forces[::many], drive[1, ::many], theta_dd[1, ::many])

    def steps_of(self, numbers: Numbers) -> Steps:
        """How the joint without play goes on over a substep. numbers: with those declared."""
        driven, step = self.driven, self.driven.step_s / self.substeps
        factor = 1.0 + numbers.get("inertia_step", 0.0)
        switch = driven.samples if factor == 1.0 else round(numbers["onset"] / driven.step_s)
        linear, law = self.linear(numbers), laws_of(numbers)
        steps = [transition(linear, step)]
        steps.append(steps[0] if factor == 1.0 else transition(self.linear(numbers, max(factor, 0.05)), step))
        law[OF_JOINT] /= 1.0 + numbers.get("inertia_excess", 0.0)
        laws = np.array([law, law])
        laws[1, OF_JOINT] /= factor
        late = any(is_late(one, numbers) for one in driven.outputs)
        phi, g = np.array([one[0] for one in steps]), np.array([one[1] for one in steps])
        return Steps(linear, phi, g, laws, switch, self.substeps if late else 1)

    def _with_play(self, numbers: Numbers, law: Array, states: Array) -> Run:
        """States: the link's, then the motor's angle and velocity."""
        driven, parts = self.driven, self.substeps * PARTS_OF_PLAY
        step = driven.step_s / parts
        u = self.driving(numbers, parts)
        n, geared = 2 + 2 * self.modes, self.geared(numbers)
        link = geared.link
        out, contact = np.empty((driven.samples, n + 2)), np.empty(driven.samples)
        play_run(
            *geared.joint, law, geared.phi, geared.held, u, parts, step, self.starts, states, out, contact
        )
        drive = before_and_after(u, parts)
        forces = np.column_stack([contact, np.zeros(driven.samples)])
        a, _ = link.equations()
        accelerations = out[:, :n] @ a[1] + contact, np.gradient(out[:, n + 1], driven.step_s)
        shown = {}
        for one in driven.outputs:
            side = on_motor(one, numbers)
            z = np.column_stack([out[:, n:], out[:, 2:n]]) if side else out[:, :n]
            motion = Motion(link, z, forces, drive, np.stack([accelerations[int(side)]] * 2))
            shown[one.name] = seen(one, numbers, motion, driven.step_s, self.starts)
        return Run(shown, out, forces, drive[1], accelerations[0])

    def geared(self, numbers: Numbers) -> Geared:
        """Motor and link with play between them, over a substep. numbers: with those declared."""
        share, whole = min(max(numbers["share"], 0.02), 0.98), self.linear(numbers)
        link = link_of(whole, share)
        phi, g = transition(link, self.driven.step_s / (self.substeps * PARTS_OF_PLAY))
        joint = share, whole.gain, whole.damping, max(numbers["gap"], 0.0), numbers.get("bounce", 0.0)
        return Geared(joint, link, phi, np.ascontiguousarray(g[:, 2]))

    def first_states(self, numbers: Numbers) -> Array:
        """Where the blocks begin as far as the sensors tell: (blocks, size)."""
        states = np.zeros((len(self.starts) - 1, self.size))
        h = self.driven.step_s
        for output in self.driven.outputs:
            place = {"position": 0, "motor": 0, "velocity": 1, "deflection": 2}.get(output.kind)
            if place is None or place >= 2 + 2 * self.modes:
                continue
            for s, (a, b) in enumerate(zip(self.starts[:-1], self.starts[1:], strict=True)):
                head = output.values[a : min(a + max(8, int(0.03 / h)), b)]
                known = np.flatnonzero(np.isfinite(head))
                if len(known) < 3:
                    continue
                line = np.polyfit(known * h, head[known], 1) / (
                    numbers.get(f"scale {output.name}", 1.0) or 1.0
                )
                states[s, place] = line[1]
                if place != 1:
                    states[s, place + 1] = line[0]
        if all(one.kind not in ("position", "motor") for one in self.driven.outputs):
            states[:, 0] = self._turned
        if self.play:
            states[:, -2:] = states[:, :2]
        return states

    @cached_property
    def _turned(self) -> Array:
        """By how much the joint has turned where each block begins, as a velocity alone tells: what repeats over the
        angle then has one phase in all blocks. Zero where no sensor looks at the joint."""
        motion = joint_motion(self.driven)
        return np.zeros(len(self.starts) - 1) if motion is None else motion[0][self.starts[:-1]]


def on_motor(output: Output, numbers: Numbers) -> bool:
    """Whether a sensor sits on the motor's side of the play."""
    return output.kind == "motor" or bool(numbers.get(_SIDES.get(output.kind, ""), 0.0))


def _joined(runs: list[Run]) -> Run:
    """Runs of recordings, one after the other."""
    return Run(
        {name: np.concatenate([one.outputs[name] for one in runs]) for name in runs[0].outputs},
        np.concatenate([one.states for one in runs]),
        np.concatenate([one.forces for one in runs]),
        np.concatenate([one.drive for one in runs]),
        np.concatenate([one.acceleration for one in runs]),
    )
