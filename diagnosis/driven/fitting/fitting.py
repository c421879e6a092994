"""Fits a grey box to the blocks that train it: Gauss-Newton steps, each block's initial state projected out.

The state of every block enters as its own unknowns; by QR they are removed from the normal equations of the numbers
that are common to all (variable projection: Golub and Pereyra, SIAM J. Numerical Analysis 10, 1973). A held-out block
gives its own initial state and nothing else. Derivatives are differences: one simulation for each number, and one for
each component of the state, of all blocks at once.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.driven.fitting.block_states import begun_states, settled_states
from stillarm.diagnosis.driven.fitting.by_frequency import likelier
from stillarm.diagnosis.driven.fitting.derivatives import (
    ASTRAY,
    by_block,
    cost_of,
    derivatives,
    first_levels,
    levels_of,
    rescaled,
)
from stillarm.diagnosis.driven.fitting.gauss_newton import RIDGE, Piece, normal_of, state_steps, stepped
from stillarm.diagnosis.driven.fitting.scoring import scored
from stillarm.diagnosis.driven.greybox.greybox import GreyBox, Run
from stillarm.diagnosis.driven.recording.own import base_of, numbers_in, recording_of, with_own

Array = NDArray[np.float64]
Simulate = Callable[[dict[str, float], Array], Run]

SEARCH_STEPS = 18
"""Of a fit of a form that is tried: what a round of the search costs."""
NEAR_STEPS = 10
"""Of a fit from the final model, which is near its end."""

_DAMPING, _MOST_DAMPING = 1e-3, 1e7  # of the diagonal (Levenberg, Marquardt): at first; a step is then none
_SETTLED = 1e-4  # of the cost, from one step to the next


@dataclass(frozen=True)
class DrivenFit:
    """numbers: all of them; free: those fitted; std: of these, by the spread that their residual has.

    residuals: by output, NaN where not measured. held_bands, whole_bands: nats of each block and band of frequency,
    (blocks, bands + 1), with levels learnt on the blocks that trained, and on all.
    """

    box: GreyBox
    numbers: dict[str, float]
    free: tuple[str, ...]
    states: Array
    std: dict[str, float]
    residuals: dict[str, Array]
    run: Run
    held_bands: Array
    whole_bands: Array
    given_up: bool = False
    """Whether steps gained too little for what they were to decide, and might have gained more."""
    at_best: bool = False
    """Whether the score is that of the likeliest numbers."""

    @cached_property
    def likeliest(self) -> "DrivenFit":
        """The fit as it is judged: its numbers where the score itself is best, and not the sum of squares."""
        if self.at_best:
            return self
        sigma = levels_of_fit(self)
        numbers, states = likelier(self.box, self.numbers, self.free, self.states, self.residuals, sigma)
        found = _finished(self.box, numbers, self.free, states, self.std)
        better = float(found.held_out[~found.box.split.held].sum()) > float(
            self.held_out[~self.box.split.held].sum()
        )
        return replace(found if better else self, given_up=self.given_up, at_best=True)

    @property
    def held_out(self) -> Array:
        """Nats of each block, with levels learnt on those that trained."""
        return np.asarray(self.held_bands.sum(axis=1))

    @property
    def whole(self) -> Array:
        """Nats of each block, with levels learnt on all."""
        return np.asarray(self.whole_bands.sum(axis=1))

    def rms(self, name: str, held: bool) -> float:
        """Of an output's residual, on the blocks that are held out, or those that trained."""
        inside = self.box.split.held[self.box.block] == held
        return float(np.sqrt(np.nanmean(self.residuals[name][inside] ** 2)))

    def part(self, recording: int) -> "DrivenFit":
        """The fit as one of several recordings sees it. free: what that recording has for itself alone."""
        box = self.box.parts[recording]
        blocks = self.box.recording == recording
        rows = blocks[self.box.block]
        run = self.run
        seen = Run(
            {name: values[rows] for name, values in run.outputs.items()},
            run.states[rows], run.forces[rows], run.drive[rows], run.acceleration[rows],
        )  # fmt: skip
        own = tuple(base_of(name) for name in self.free if recording_of(name) == recording)
        return DrivenFit(
            box, numbers_in(self.numbers, recording), own, self.states[blocks],
            numbers_in(self.std, recording), {name: one[rows] for name, one in self.residuals.items()},
            seen, self.held_bands[blocks], self.whole_bands[blocks],
        )  # fmt: skip


def fit(
    box: GreyBox, numbers: dict[str, float], free: Sequence[str], states: Array | None = None, steps: int = 15,
    least: float = 0.0,
) -> DrivenFit:  # fmt: skip
    """The likeliest numbers near those given. A block begins in the state that is given, or that the sensors tell.
    least: nats of a step, once the fit has had a third of its steps, below which it is given up."""
    free = tuple(free)
    numbers = with_own(numbers, free)
    sigma = first_levels(box)
    states = settled_states(box, numbers, begun_states(box, numbers, states, sigma), sigma)
    first, (_, errors) = sigma, cost_of(box, numbers, states, sigma)
    sigma = levels_of(box, errors, first)
    cost, errors = rescaled(box, errors, first, sigma)
    damping = _DAMPING
    normal, given_up = np.eye(len(free)), False
    for turn in range(steps):
        pieces = derivatives(box, numbers, free, states, sigma, errors)
        normal, gradient = normal_of(pieces, len(free))
        moved = False
        while damping < _MOST_DAMPING:
            scaled = normal + damping * np.diag(np.diag(normal)) + RIDGE * np.eye(len(free))
            trial, step = stepped(box, numbers, free, scaled, gradient)
            trial_states = states + state_steps(pieces, step)
            trial_cost, trial_errors = cost_of(box, trial, trial_states, sigma)
            if not trial_cost < cost:
                # a block's own step is not damped: where it goes astray, at a corner of friction, its state stays
                astray = by_block(box, trial_errors) > by_block(box, errors)
                trial_states = np.where(astray[:, None], states, trial_states)
                trial_cost, trial_errors = cost_of(box, trial, trial_states, sigma)
            if trial_cost < cost:
                moved = True
                break
            damping *= 6.0
        if not moved:
            break
        gained = cost - trial_cost
        numbers, states, errors = trial, trial_states, trial_errors
        settled = gained < _SETTLED * cost
        given_up = not settled and gained < least and 3 * turn >= steps
        damping = max(damping / 10.0, 1e-7)
        if settled or given_up:
            break
        before, sigma = sigma, levels_of(box, errors, sigma)
        cost, errors = rescaled(box, errors, before, sigma)
    states = settled_states(box, numbers, states, sigma, 3)
    found = _finished(box, numbers, free, states, _spread_of(free, normal))
    return replace(found, given_up=given_up)


def runs_away(box: GreyBox, numbers: dict[str, float], states: Array) -> bool:
    """Whether the simulation leaves all bounds: a joint that friction drives on, or a spring that pushes."""
    _, errors = cost_of(box, numbers, states, first_levels(box))
    return bool(np.any(np.abs(errors) >= ASTRAY))


def levels_of_fit(fitted: DrivenFit) -> dict[str, float]:
    """The outputs' deviations, by what the fit leaves where it was trained."""
    ones = dict.fromkeys(fitted.residuals, 1.0)
    return levels_of(fitted.box, _stacked(fitted), ones)


def linearised(fitted: DrivenFit, sigma: dict[str, float]) -> list[Piece]:
    """A fit's derivatives and residual by blocks."""
    box = fitted.box
    errors = _stacked(fitted) * box.stack.deviations(sigma)
    return derivatives(box, fitted.numbers, fitted.free, fitted.states, sigma, errors)


def _stacked(fitted: DrivenFit) -> Array:
    """A fit's residuals, stacked."""
    outputs = fitted.box.driven.outputs
    return fitted.box.stack.of([np.nan_to_num(fitted.residuals[one.name]) for one in outputs])


def _spread_of(free: tuple[str, ...], normal: Array) -> dict[str, float]:
    """Of the free numbers, by a fit's normal matrix."""
    try:
        spread = np.sqrt(np.maximum(np.diag(np.linalg.inv(normal + RIDGE * np.eye(len(free)))), 0.0))
    except np.linalg.LinAlgError:
        spread = np.full(len(free), np.nan)
    return dict(zip(free, spread.tolist(), strict=True))


def _finished(
    box: GreyBox, numbers: dict[str, float], free: tuple[str, ...], states: Array, std: dict[str, float]
) -> DrivenFit:
    """A fit as its steps have left it."""
    run = box.run(numbers, states)
    residuals = {one.name: one.values - run.outputs[one.name] for one in box.driven.outputs}
    held, whole = scored(box, residuals)
    return DrivenFit(box, numbers, free, states, std, residuals, run, held, whole)
