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
from scipy.special import gammaincinv, gammaln

from stillarm.diagnosis.data.channels import FRAME_CHANNELS
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.inference.fitted import THIN, Fit, least_level, thinned

Array = NDArray[np.float64]

_LOWEST_HZ, _WIDTH = 0.3, 1.25  # of the bands: a quarter wide, as a ringing of a few periods is
_SHAPES = (1.0, 2.0, 4.0, 8.0, 16.0, 64.0, 1e4)
_TURNS = 30  # of the fixed point that gives S: to 1e-3
_FEWEST = 12  # samples of a block
_QUIET, _MOST_COLOUR = 0.25, 4.0  # of the blocks; times the white noise's power


@dataclass(frozen=True)
class Spectra:
    """A channel's residual by blocks and bands. count, power: (blocks, bands + 1), the mean first; least: variance."""

    count: Array
    power: Array
    least: float


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

    def gain_of(self, before: "Score", channel: str) -> float:
        """Nats more than another's in a channel."""
        return float((self.whole[channel] - before.whole[channel]).sum())


def score(fit: Fit, split: Split) -> Score:
    """Judge a fit block by block."""
    held, whole = {}, {}
    everywhere = np.ones(len(split.held), bool)
    for name in fit.residuals:
        spectra = _spectra(fit, name, split)
        held[name] = _nats(spectra, ~split.held)
        whole[name] = _nats(spectra, everywhere)
    return Score(held, whole)


def noise_spectrum(fit: Fit, name: str, split: Split, white: float) -> tuple[Array, Array]:
    """A channel's noise by bands: how many values each holds, and their level (variance), from `white` (deviation) up.

    What is there in the quietest quarter of the blocks too is taken for the sensor's own noise, up to twice the white
    one's amplitude: sensors' filters colour it by as much. (The quantile is put right for the number of values.)"""
    spectra = _spectra(fit, name, split)
    return spectra.count.sum(axis=0), _noise_level(spectra, white)


def _noise_level(spectra: Spectra, white: float) -> Array:
    count = spectra.count.sum(axis=0)
    seen = count > 0.0
    there = np.where(spectra.count > 0.0, 1.0, np.nan)[:, seen]
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = there * spectra.power[:, seen] / spectra.count[:, seen]
    usual = np.nanmedian(there * spectra.count[:, seen], axis=0)
    least = max(white**2, spectra.least)
    level = np.full(len(count), least)
    quiet = np.nanquantile(mean, _QUIET, axis=0) / (gammaincinv(usual, _QUIET) / usual)
    level[seen] = np.clip(quiet, least, _MOST_COLOUR * least)
    return level


def score_of_noise(fit: Fit, name: str, split: Split, white: float) -> float:
    """What the log score of a channel would be, nats over all blocks, if nothing but its own noise were left."""
    spectra = _spectra(fit, name, split)
    level = _noise_level(spectra, white)
    nats = _log_density(spectra.count, spectra.count * level, level, _SHAPES[-1])
    return float(np.where(spectra.count > 0.0, nats, 0.0).sum())


def _spectra(fit: Fit, name: str, split: Split) -> Spectra:
    world = fit.world
    time = world.measured.frames.received_s if name in FRAME_CHANNELS else world.cycle_times
    step = world.step_s(name)
    many = THIN.get(name, 1)
    residual = fit.residuals[name]
    if many > 1:
        residual = thinned(name, residual)
        time = time[: len(residual) * many : many]
        step *= many
    least = least_level(world, name) / many**0.5
    block = split.blocks_of(time)
    highest = 0.5 / step
    bands = max(1, int(np.log(highest / _LOWEST_HZ) / np.log(_WIDTH)))
    edges = np.geomspace(_LOWEST_HZ, highest * 1.001, bands + 1)
    edges[0] = 1e-9
    blocks = len(split.held)
    count, power = np.zeros((blocks, bands + 1)), np.zeros((blocks, bands + 1))
    for b in range(blocks):
        one = residual[block == b]
        known = np.isfinite(one)
        if known.sum() < _FEWEST:
            continue
        one = np.where(known, one, 0.0)
        periodogram = np.abs(np.fft.rfft(one)) ** 2 / known.sum()
        share = known.mean()  # a block tells no more than it has samples, whatever its length
        band = np.searchsorted(edges, np.fft.rfftfreq(len(one), step)[1:], side="right").clip(1, bands)
        count[b, 0], power[b, 0] = 0.5, 0.5 * periodogram[0]
        count[b, 1:] = share * np.bincount(band, minlength=bands + 1)[1:]
        power[b, 1:] = share * np.bincount(band, periodogram[1:], minlength=bands + 1)[1:]
    return Spectra(count, power, least**2)


def _log_density(count: Array, power: Array, level: Array, shape: Array | float) -> Array:
    return np.asarray(
        shape * np.log(shape) + gammaln(count + shape) - gammaln(shape) - count * np.log(level)
        - (count + shape) * np.log(shape + power / level)
    )  # fmt: skip


def _nats(spectra: Spectra, learnt_on: NDArray[np.bool_]) -> Array:
    """Log density of each block, by the likeliest level and shape of each band on some blocks."""
    count, power = spectra.count[learnt_on], spectra.power[learnt_on]
    total = np.maximum(count.sum(axis=0), 1e-9)
    first = np.maximum(power.sum(axis=0) / total, spectra.least)
    level, shape = first.copy(), np.full(len(first), _SHAPES[-1])
    best = np.full(len(first), -np.inf)
    for tried in _SHAPES:
        at = first.copy()
        for _ in range(_TURNS):
            size = power / at
            ratio = ((count + tried) * size / (tried + size)).sum(axis=0) / total
            at = np.maximum(at * np.clip(ratio, 0.2, 5.0), spectra.least)
        nats = _log_density(count, power, at, tried).sum(axis=0)
        better = nats > best
        level[better], shape[better], best[better] = at[better], tried, nats[better]
    found = _log_density(spectra.count, spectra.power, level, shape)
    return np.asarray(np.where(spectra.count > 0.0, found, 0.0).sum(axis=1))
