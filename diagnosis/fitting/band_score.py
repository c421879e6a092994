"""A residual by blocks and bands of frequency, and how well it is foretold: the log score of a discrepancy's spectrum.

    log p(I_1..I_n) = a log a + log G(n + a) - log G(a) - n log S - (n + a) log(a + sum I / S)

S and a are learnt for each band: evidence.py says why, and from where it is.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

Array = NDArray[np.float64]

SHAPES = (1.0, 2.0, 4.0, 8.0, 16.0, 64.0, 1e4)
"""Shapes a that are tried: a block's level strays by about 1 / sqrt(a) of itself, at the last not at all."""
_LOWEST_HZ, _WIDTH = 0.3, 1.25  # of the bands: a quarter wide, as a ringing of a few periods is
_TURNS = 30  # of the fixed point that gives S: to 1e-3
_FEWEST = 12  # known samples of a block: of fewer it counts for nothing


@dataclass(frozen=True)
class Spectra:
    """A channel's residual by blocks and bands. count, power: (blocks, bands + 1), the mean first; least: variance."""

    count: Array
    power: Array
    least: float


def _edges(step_s: float) -> Array:
    """Of the bands, Hz."""
    highest = 0.5 / step_s
    bands = max(1, int(np.log(highest / _LOWEST_HZ) / np.log(_WIDTH)))
    edges = np.geomspace(_LOWEST_HZ, highest * 1.001, bands + 1)
    edges[0] = 1e-9
    return np.asarray(edges, np.float64)


def band_of(samples: int, step_s: float) -> NDArray[np.int64]:
    """Number of the band of each frequency of a real Fourier transform, the mean's zero."""
    edges = _edges(step_s)
    band = np.searchsorted(edges, np.fft.rfftfreq(samples, step_s), side="right").clip(1, len(edges) - 1)
    band[:1] = 0
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
        at = first.copy()
        for _ in range(_TURNS):
            size = power / at
            ratio = ((count + tried) * size / (tried + size)).sum(axis=0) / total
            at = np.maximum(at * np.clip(ratio, 0.2, 5.0), by_bands.least)
        density = log_density(count, power, at, tried).sum(axis=0)
        better = density > best
        level[better], shape[better], best[better] = at[better], tried, density[better]
    return level, shape
