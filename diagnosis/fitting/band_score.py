"""A residual by blocks and bands of frequency, and how well it is foretold: the log score of a discrepancy's spectrum.

    log p(I_1..I_n) = a log a + log G(n + a) - log G(a) - n log S - (n + a) log(a + sum I / S)

S and a are learnt for each band: evidence.py says why, and from where it is.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

Array = NDArray[np.float64]

SHAPES = (1.0, 2.0, 4.0, 8.0, 16.0, 64.0, 1e4)
"""Shapes a that are tried: a block's level strays by about 1 / sqrt(a) of itself, at the last not at all."""
_LOWEST_HZ, _WIDTH = 0.3, 1.25  # of the bands: a quarter wide, as a ringing of a few periods is
# steps of Newton's method that gives S, at most; relative accuracy at which it ends; e^step, the widest
_STEPS, _TO, _WIDEST = 20, 1e-5, 1.6
_FEWEST = 12  # known samples of a block: of fewer it counts for nothing


@dataclass(frozen=True)
class Spectra:
    """A channel's residual by blocks and bands. count, power: (blocks, bands + 1), the mean first; least: variance."""

    count: Array
    power: Array
    least: float


@lru_cache(maxsize=16)
def _edges(step_s: float) -> Array:
    """Of the bands, Hz. Read-only."""
    highest = 0.5 / step_s
    bands = max(1, int(np.log(highest / _LOWEST_HZ) / np.log(_WIDTH)))
    edges = np.geomspace(_LOWEST_HZ, highest * 1.001, bands + 1)
    edges[0] = 1e-9
    edges.flags.writeable = False
    return np.asarray(edges, np.float64)


@lru_cache(maxsize=64)
def band_of(samples: int, step_s: float) -> NDArray[np.int64]:
    """Number of the band of each frequency of a real Fourier transform, the mean's zero. Read-only."""
    edges = _edges(step_s)
    band = np.searchsorted(edges, np.fft.rfftfreq(samples, step_s), side="right").clip(1, len(edges) - 1)
    band[:1] = 0
    band.flags.writeable = False
    return band


def spectra(residual: Array, step_s: float, block: NDArray[np.int64], blocks: int, least: float) -> Spectra:
    """Of a residual, (n,), NaN where there is none. block: (n,) number of each sample's; least: deviation that its
    noise has at least."""
    edges = _edges(step_s)
    bands = len(edges) - 1
    count, power = np.zeros((blocks, bands + 1)), np.zeros((blocks, bands + 1))
    for b in range(blocks):
        one = residual[block == b]
        known = np.isfinite(one)
        if known.sum() < _FEWEST:
            continue
        one = np.where(known, one, 0.0)
        periodogram = np.abs(np.fft.rfft(one)) ** 2 / known.sum()
        share = known.mean()  # a block tells no more than it has samples, whatever its length
        band = band_of(len(one), step_s)[1:]
        count[b, 0], power[b, 0] = 0.5, 0.5 * periodogram[0]
        count[b, 1:] = share * np.bincount(band, minlength=bands + 1)[1:]
        power[b, 1:] = share * np.bincount(band, periodogram[1:], minlength=bands + 1)[1:]
    return Spectra(count, power, least**2)


def log_density(count: Array, power: Array, level: Array, shape: Array | float) -> Array:
    """Of bands that hold `count` values of a summed power, at a level and a shape."""
    return np.asarray(
        shape * np.log(shape) + gammaln(count + shape) - gammaln(shape) - count * np.log(level)
        - (count + shape) * np.log(shape + power / level)
    )  # fmt: skip


def nats(by_bands: Spectra, learnt_on: NDArray[np.bool_]) -> Array:
    """Log density of each block, by the likeliest level and shape of each band on some blocks."""
    return np.asarray(nats_by_band(by_bands, learnt_on).sum(axis=1))


def nats_by_band(by_bands: Spectra, learnt_on: NDArray[np.bool_]) -> Array:
    """The same of each block and band, (blocks, bands + 1)."""
    level, shape = level_and_shape(by_bands, learnt_on)
    found = log_density(by_bands.count, by_bands.power, level, shape)
    return np.asarray(np.where(by_bands.count > 0.0, found, 0.0))


def level_and_shape(by_bands: Spectra, learnt_on: NDArray[np.bool_]) -> tuple[Array, Array]:
    """The likeliest of each band on some blocks, (bands + 1,)."""
    count, power = by_bands.count[learnt_on], by_bands.power[learnt_on]
    total = np.maximum(count.sum(axis=0), 1e-9)
    first = np.maximum(power.sum(axis=0) / total, by_bands.least)
    level, shape = first.copy(), np.full(len(first), SHAPES[-1])
    best = np.full(len(first), -np.inf)
    for tried in SHAPES:
        at = _likeliest_level(count, power, tried, first, by_bands.least)
        density = log_density(count, power, at, tried).sum(axis=0)
        better = density > best
        level[better], shape[better], best[better] = at[better], tried, density[better]
    return level, shape


def _likeliest_level(count: Array, power: Array, shape: float, first: Array, least: float) -> Array:
    """Level S of each band at a shape a, (bands + 1,): where sum (n + a) I / (a S + I) = sum n over the blocks, by
    Newton's method in log S. first: where it begins; least: below which no level is."""
    at, weight, total = first, count + shape, count.sum(axis=0)
    for _ in range(_STEPS):
        size = power / at
        share = size / (shape + size)
        falls = (weight * share * (1.0 - share)).sum(axis=0)
        step = ((weight * share).sum(axis=0) - total) / np.maximum(falls, 1e-300)
        then = np.maximum(at * np.exp(np.clip(step, -_WIDEST, _WIDEST)), least)
        settled, at = (np.abs(then - at) <= _TO * at).all(), then
        if settled:
            break
    return at
