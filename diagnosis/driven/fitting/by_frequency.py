"""Numbers carried on to where the score that judges them is best: each block and band weighs what it counts there.

A fit weighs all frequencies alike, and is judged by each for itself. So a delay that serves the strong frequencies may
cost more at the weak ones than a cause gains, and what a form is worth would depend on how well the numbers beside it
happen to suit the score. With P the power of a block's band, n its values, and S and a the band's level and shape
(fitting/band_score.py), the score holds

    - (n + a) log(a + P / S),

which is convex in P. Its tangent, a sum of squares with weights (n + a) / (a S + P), lies below it, and what lessens
that sum raises the score (majorisation: Hunter, Lange, The American Statistician 58, 2004).

The blocks' states follow the numbers by plain squares. A band may hold one frequency of a block, and a mode's state
makes it vanish in every block, however wrong the model is: its level, and with it the score, would have no bound.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft

from stillarm.diagnosis.driven.fitting.block_states import settled_states
from stillarm.diagnosis.driven.fitting.derivatives import cost_of, derivatives
from stillarm.diagnosis.driven.fitting.gauss_newton import RIDGE, Piece, state_steps, stepped
from stillarm.diagnosis.driven.fitting.scoring import spectra_of
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.fitting.band_score import Spectra, band_of, level_and_shape, log_density

Array = NDArray[np.float64]
Numbers = dict[str, float]

_STEPS = 15  # the weights are found anew with each; three gain 98 % of most fits of seed 70080
_DAMPING, _LEAST_DAMPING, _MOST_DAMPING = 1e-6, 1e-9, 1e3  # of the diagonal (Levenberg, Marquardt)
_SETTLED = 0.5  # nats of a step


def likelier(
    box: GreyBox, numbers: Numbers, free: tuple[str, ...], states: Array, residuals: dict[str, Array],
    sigma: dict[str, float],
) -> tuple[Numbers, Array]:  # fmt: skip
    """Numbers and states of the blocks after some steps that raise the score of the blocks that train. residuals: of
    the fit that they come from; sigma: the outputs' deviations."""
    bands, damping = _Bands.of(box, residuals, sigma), _DAMPING
    _, errors = cost_of(box, numbers, states, sigma)
    powers = bands.powers(errors)
    weights, score = bands.weights(powers)
    for _ in range(_STEPS if free else 0):
        found = derivatives(box, numbers, free, states, sigma, errors)
        normal, gradient = weights.normal_of(found, len(free))
        before = _trained(box, weights.squares(powers))
        while damping < _MOST_DAMPING:
            scaled = normal + damping * np.diag(np.diag(normal)) + RIDGE * np.eye(len(free))
            trial, step = stepped(box, numbers, free, scaled, gradient)
            moved = states + state_steps(found, step)
            _, tried = cost_of(box, trial, moved, sigma)
            tried_powers = bands.powers(tried)
            if _trained(box, weights.squares(tried_powers)) < before:
                break
            damping *= 10.0
        else:
            break
        after, raised = bands.weights(tried_powers)
        if raised <= score:
            break
        gained, numbers, states, errors, powers = raised - score, trial, moved, tried, tried_powers
        weights, score, damping = after, raised, max(damping / 10.0, _LEAST_DAMPING)
        if gained < _SETTLED:
            break
    return numbers, settled_states(box, numbers, states, sigma)


def _trained(box: GreyBox, squares: Array) -> float:
    return float(squares[~box.split.held].sum())


@dataclass(frozen=True)
class _Bands:
    """spectra: of each recording's outputs, what a fit leaves; of these the counts stay, whatever the numbers."""

    box: GreyBox
    spectra: list[list[Spectra]]
    sigma: dict[str, float]

    @classmethod
    def of(cls, box: GreyBox, residuals: dict[str, Array], sigma: dict[str, float]) -> "_Bands":
        found = []
        for k, part in enumerate(box.parts):
            rows = (box.recording == k)[box.block]
            found.append([spectra_of(part, one, residuals[one.name][rows]) for one in part.driven.outputs])
        return cls(box, found, sigma)

    @cached_property
    def places(self) -> list[NDArray[np.int64]]:
        """Of each block, the band of each frequency of its samples' Fourier transform."""
        return [band_of(int(n), self.box.driven.step_s) for n in np.diff(self.box.starts)]

    def powers(self, errors: Array) -> Array:
        """By block, output and band, in deviations."""
        outputs, bands = len(self.box.driven.outputs), self.spectra[0][0].power.shape[1]
        found = np.zeros((len(self.places), outputs, bands))
        for k, (a, b) in enumerate(self.box.stack.bounds):
            if b > a:
                parts = errors[a:b].reshape(outputs, -1)
                periodogram = np.abs(rfft(parts, axis=1)) ** 2 / parts.shape[1]
                found[k] = [np.bincount(self.places[k], one, minlength=bands) for one in periodogram]
        return found

    def weights(self, powers: Array) -> tuple["_Weights", float]:
        """What a power counts beside these, and the score of the blocks that train."""
        box, weights, score = self.box, np.empty_like(powers), 0.0
        for k, of_recording in enumerate(self.spectra):
            blocks = np.flatnonzero(box.recording == k)
            trains = ~box.split.held[blocks]
            for place, (one, known) in enumerate(zip(box.driven.outputs, of_recording, strict=True)):
                square = self.sigma[one.name] ** 2
                now = Spectra(known.count, square * powers[blocks, place], known.least)
                now.power[:, 0] = 0.0
                level, shape = level_and_shape(now, trains)
                weights[blocks, place] = square * (now.count + shape) / (shape * level + now.power)
                score += float(
                    log_density(now.count, now.power, level, shape)[trains][now.count[trains] > 0.0].sum()
                )
        weights[:, :, 0] = 0.0
        return _Weights(self.places, weights), score


@dataclass(frozen=True)
class _Weights:
    """places: of each block, see _Bands; by_band: (blocks, outputs, bands), nats for a power in deviations."""

    places: list[NDArray[np.int64]]
    by_band: Array

    def normal_of(self, pieces: list[Piece], count: int) -> tuple[Array, Array]:
        """Normal matrix and gradient of the numbers, of the blocks that train, weighed; the states follow."""
        normal, gradient = np.zeros((count, count)), np.zeros(count)
        outputs = self.by_band.shape[1]
        for one, by_band, places in zip(pieces, self.by_band, self.places, strict=True):
            if not one.trains or not len(one.left):
                continue
            by_numbers, left = one.free
            columns = np.vstack([by_numbers.T, left]).reshape(count + 1, outputs, -1)
            gain = np.sqrt(by_band[:, places] / columns.shape[-1])
            weighed = (
                np.ascontiguousarray(gain * rfft(columns, axis=-1)).reshape(count + 1, -1).view(np.float64)
            )
            normal += weighed[:-1] @ weighed[:-1].T
            gradient += weighed[:-1] @ weighed[-1]
        return normal, gradient

    def squares(self, powers: Array) -> Array:
        """Each block's weighed sum of squares, nats."""
        return np.asarray((self.by_band * powers).sum(axis=(1, 2)))


__all__ = ["likelier"]
