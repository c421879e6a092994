"""The accelerometer in short blocks: each becomes one mean value at one mean phase.

Implements Eqs. 11, 49, 55 of docs/fused.md.

Over a block of a twenty-fourth of a period the mean keeps all but half a percent of the samples' information.
"""

from cmath import exp
from dataclasses import dataclass
from math import nan
from typing import NamedTuple

from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions
from stillarm.controller.estimation.fused.assumptions.sensor_assumptions import BlockAssumptions


def along_rate(w: float, time_s: float) -> complex:
    """Change of a mode's phasor per unit of its rate over w, for a step of the rate at time_s."""
    return -1j * exp(-1j * w * time_s)


class Jump(NamedTuple):
    """Uncertainty of each mode's phasor by an impact at time_s: standard deviations, m.

    along_m: in the direction of a change of rate at time_s; across_m: at right angles to it. force_m: of the first
    mode's static deflection by a force that changed at time_s (held_force.py), of which force_step_m is known.
    """

    time_s: float
    along_m: tuple[float, ...]
    across_m: tuple[float, ...]
    force_m: float = 0.0
    force_step_m: float = 0.0

    @classmethod
    def guessed(
        cls,
        time_s: float,
        sizes_m: tuple[float, ...],
        force_m: float = 0.0,
        assumed: BlockAssumptions = ASSUMPTIONS.blocks,
    ) -> "Jump":
        """An impact of about those sizes, and a change of force of about that size, at about that time."""
        along, across = (
            tuple(assumed.along * one for one in sizes_m),
            tuple(assumed.across * one for one in sizes_m),
        )
        return cls(time_s, along, across, assumed.along * force_m)

    @classmethod
    def stepped(cls, time_s: float, size_m: float, assumed: BlockAssumptions = ASSUMPTIONS.blocks) -> "Jump":
        """A force has changed at that time by size_m, as the accelerometer has seen, in an arm of one mode."""
        doubt = assumed.step_doubt * abs(size_m)
        return cls(time_s, (doubt,), (doubt,), doubt, size_m)


@dataclass(slots=True)
class Block:
    """One block. start_s to end_s; count samples used; value: their mean as deflection of the first mode, m.

    turn: mean of exp(i w t) of each mode; time_s: mean time; forced: mean contribution of the joint's motion since
    start_s to the value; variance: of the value; step: the joint's phasor increments from start to end, and those of a
    impact that was measured. jumps: unknown changes by impacts in it. scatter: variance of a sample about the block's
    mean, m^2, to which a wrong vibration adds nothing; nan for fewer than two samples.
    """

    start_s: float
    end_s: float
    count: int = 0
    value: float = 0.0
    turn: tuple[complex, ...] = ()
    time_s: float = 0.0
    forced: float = 0.0
    variance: float = 0.0
    step: tuple[complex, ...] = ()
    jumps: tuple[Jump, ...] = ()
    scatter: float = nan

    def motion_variance(self, doubt: float) -> float:
        """Variance of each part of a phasor, m^2, if the joint's effect on the arm is known to the share `doubt`."""
        return 0.5 * sum([(doubt * abs(one)) ** 2 for one in self.step])


class BlockSums:
    """Sums over the block under way."""

    def __init__(self, modes: int, assumed: Assumptions = ASSUMPTIONS) -> None:
        """Empty."""
        self._grown = assumed.blocks.grown
        self._none = [0j] * modes
        self.clear()

    def clear(self) -> None:
        """Begin anew."""
        self._count = 0
        self._value = self._time = self._forced = self._squares = self._residual = 0.0
        self._turn = self._none.copy()

    def add(self, value: float, turn: list[complex], time_s: float, forced: float, residual: float) -> None:
        """Process one good sample, and how far it lay from what was expected."""
        self._count += 1
        self._squares += residual * residual
        self._residual += residual
        self._value += value
        self._time += time_s
        self._forced += forced
        sums = self._turn
        for i, one in enumerate(turn):
            sums[i] += one

    def close(self, start_s: float, end_s: float, variance: float, step: tuple[complex, ...]) -> Block:
        """The block's means. variance: of one sample, unless the block scatters far more: noise that has grown."""
        n = self._count
        if n == 0:
            return Block(start_s, end_s, step=step)
        own = self._squares / n
        if own > self._grown * variance:
            variance = own
        return Block(
            start_s, end_s, n, self._value / n, tuple(one / n for one in self._turn),
            self._time / n, self._forced / n, variance / n, step,
            scatter=(self._squares - self._residual**2 / n) / (n - 1) if n > 1 else nan,
        )  # fmt: skip
