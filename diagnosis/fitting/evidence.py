"""How well a fit foretells each block of the recording, when every model is a little off: a log score by frequency.

What a model leaves is noise and discrepancy. Neither is white, nor steady: a small error of a simulation rings at the
arm's own frequency, and does so after moves. So the residual's periodogram I is judged by bands of frequency, each with
a level S of its own (Whittle's likelihood), and a block's level may lie off it by a factor u of its own, inverse gamma
with shape a:

    log p(I_1..I_n) = a log a + log G(n + a) - log G(a) - n log S - (n + a) log(a + sum I / S)

S and a are learnt for each fit, on the blocks that trained it. A rest in one band of frequency costs that band's nats,
however many samples show it; a band that is noise in every model counts for none of them.

Whittle, "Estimation and information in stationary time series", Arkiv for Matematik 2, 1953. The discrepancy as part of
the model: Kennedy and O'Hagan, JRSS B 63, 2001; Brynjarsdottir and O'Hagan, Inverse Problems 30, 2014.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincinv

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.fitting.band_score import (
    SHAPES,
    Spectra,
    level_and_shape,
    log_density,
    nats,
    spectra,
)
from stillarm.diagnosis.fitting.fitted import THIN, Fit, least_level, thinned

Array = NDArray[np.float64]

_QUIET, _MOST_COLOUR = 0.25, 4.0  # of the blocks; times the white noise's power


PRICE_NATS = 3.0
"""What each number that a form fits costs: half the logarithm of the thousand or so independent things that a block's
bands tell (Schwarz 1978)."""

CONVINCING_NATS = 12.0
"""Least merit of a finding: odds of 20 to 1 (3 nats) against each of some hundred forms, onsets and sizes tried
(log 100 = 4.6), and as much again for noise that is not quite what the score takes it for."""


@dataclass(frozen=True)
class Score:
    """A fit's log score, nats. held_out: of each block, levels learnt on those that trained; whole: of each block,
    levels learnt on all. By channel, (blocks,)."""

    held_out: dict[str, Array]
    whole: dict[str, Array]

    def gain(self, before: "Score", whole: bool = True) -> Array:
        """Nats more than another's, of each block."""
        mine, other = (self.whole, before.whole) if whole else (self.held_out, before.held_out)
        return np.asarray(sum(mine[name] - other[name] for name in mine))

    def gains(self, before: "Score") -> dict[str, float]:
        """Nats more than another's in each channel."""
        return {name: float((mine - before.whole[name]).sum()) for name, mine in self.whole.items()}


def score(fit: Fit, split: Split) -> Score:
    """Judge a fit block by block."""
    held, whole = {}, {}
    everywhere = np.ones(len(split.held), bool)
    for name in fit.residuals:
        by_bands = _spectra(fit, name, split)
        held[name] = nats(by_bands, ~split.held)
        whole[name] = nats(by_bands, everywhere)
    return Score(held, whole)


def foretold(after: Fit, before: Score, split: Split, now: Score) -> Array:
    """Nats that a fit foretells more than another in each held-out block. now: the fit's own score.

    A course over time is fitted to samples that train, and tells what lies between them. Before the first and after the
    last its amounts are anything: blocks there say nothing for the fit and nothing against it, and count as the mean of
    the others.
    """
    nats, told = now.gain(before, whole=False)[split.held], np.ones(int(split.held.sum()), bool)
    for added in after.world.added:
        for name in added.columns if added.over_time else ():
            told &= _between_trained(after, name, split)[split.held]
    return np.where(told, nats, nats[told].mean() if told.any() else 0.0)


def _between_trained(fit: Fit, name: str, split: Split) -> NDArray[np.bool_]:
    """Which blocks lie between the first and the last in which a channel trains, (blocks,)."""
    residual = fit.residuals[name]
    block = split.blocks_of(fit.world.times_of(name)[: len(residual)])
    trained = block[np.isfinite(residual) & ~split.held[block]]
    blocks = np.arange(len(split.held))
    return np.asarray(
        (blocks >= np.min(trained, initial=len(blocks))) & (blocks <= np.max(trained, initial=0))
    )


def noise_spectrum(fit: Fit, name: str, split: Split, white: float) -> tuple[Array, Array]:
    """A channel's noise by bands: how many values each holds, and their level (variance), from `white` (deviation) up.

    What is there in the quietest quarter of the blocks too is taken for the sensor's own noise, up to twice the white
    one's amplitude: sensors' filters colour it by as much. (The quantile is put right for the number of values.)"""
    by_bands = _spectra(fit, name, split)
    return by_bands.count.sum(axis=0), _noise_level(by_bands, white)


def _noise_level(by_bands: Spectra, white: float) -> Array:
    count = by_bands.count.sum(axis=0)
    seen = count > 0.0
    there = np.where(by_bands.count > 0.0, 1.0, np.nan)[:, seen]
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = there * by_bands.power[:, seen] / by_bands.count[:, seen]
    usual = np.nanmedian(there * by_bands.count[:, seen], axis=0)
    least = max(white**2, by_bands.least)
    level = np.full(len(count), least)
    quiet = np.nanquantile(mean, _QUIET, axis=0) / (gammaincinv(usual, _QUIET) / usual)
    level[seen] = np.clip(quiet, least, _MOST_COLOUR * least)
    return level


def score_of_noise(fit: Fit, name: str, split: Split, white: float, matters: float) -> float:
    """What the log score of a channel would be, nats over all blocks, if nothing but its own noise were left.

    white: the noise's deviation; matters: of what is too little to matter, in the same unit. Where that is more than
    the noise, a band keeps what it holds below it, and one that holds more is left with so much: a band of a fine
    sensor that is foretold to the noise would else make up for another that is not foretold at all."""
    by_bands = _spectra(fit, name, split)
    least = np.maximum(_noise_level(by_bands, white), matters**2 if matters > white else 0.0)
    density = log_density(by_bands.count, by_bands.count * least, least, SHAPES[-1])
    if matters > white:
        held, shape = level_and_shape(by_bands, np.ones(len(by_bands.count), bool))
        now = log_density(by_bands.count, by_bands.power, held, shape)
        density = np.where(held > least, density, now)
    return float(np.where(by_bands.count > 0.0, density, 0.0).sum())


def _spectra(fit: Fit, name: str, split: Split) -> Spectra:
    world, time = fit.world, fit.world.times_of(name)
    step = world.step_s(name)
    many = THIN.get(name, 1)
    residual = fit.residuals[name]
    if many > 1:
        residual = thinned(name, residual)
        time = time[: len(residual) * many : many]
        step *= many
    least = least_level(world, name) / many**0.5
    block = split.blocks_of(time)
    return spectra(residual, step, block, len(split.held), least)
