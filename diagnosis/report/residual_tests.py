"""Independence tests that hold for coloured residuals: correlations against Bartlett's bands.

For two independent stationary series of n samples, Bartlett (1946; Ljung, System Identification, 2nd ed., 16.6) gives

    var r_eu(lag) = 1/n sum_k rho_ee(k) rho_uu(k)

so that a coloured residual, and a coloured input, widen the band instead of raising an alarm. Friction or a cubic
stiffness may leave e and u uncorrelated; e^2 and u^2 show them (Billings and Voon, 1986).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

Array = NDArray[np.float64]
CHANCE = 0.01  # of one false alarm over all lags of a correlation
_CLIP = 6.0  # standard deviations


@dataclass(frozen=True)
class Correlation:
    """A correlation over lags. lags: in samples. band: half-width that chance leaves with 1 - CHANCE over all lags."""

    lags: NDArray[np.int64]
    values: Array
    band: Array

    @property
    def significant(self) -> bool:
        """Whether any lag lies outside the band."""
        return bool(np.any(np.abs(self.values) > self.band))

    @property
    def strongest(self) -> int:
        """Place of the lag that stands out most."""
        return int(np.argmax(np.abs(self.values) / self.band))


def standardised(values: Array) -> Array:
    """Zero mean, unit deviation, outliers bounded; a missing value is zero, which says nothing."""
    known = np.isfinite(values)
    if not known.any():
        return np.zeros(len(values))
    whole = np.where(known, values - np.mean(values[known]), 0.0)
    spread = float(np.sqrt(np.mean(whole[known] ** 2)))
    if spread <= 0.0:
        return np.zeros(len(values))
    clipped: Array = np.clip(whole / spread, -_CLIP, _CLIP)
    return clipped


def autocorrelation(e: Array, lags: NDArray[np.int64]) -> Correlation:
    """Of a residual that ought to be white, against the band of white noise. e: (n,), NaN where unmeasured."""
    x, n = standardised(e), int(np.isfinite(e).sum())
    whole = _products(x, x)
    values = whole[lags] / max(whole[0], 1e-300)
    return Correlation(lags, values, np.full(len(lags), _limit(len(lags)) / np.sqrt(max(n, 1))))


def crosscorrelation(e: Array, u: Array, lags: NDArray[np.int64]) -> Correlation:
    """Of a residual with an input `lag` samples earlier. e, u: (n,); lags: at least 0."""
    x, y = standardised(e), standardised(u)
    return _against(x, y, int(np.isfinite(e).sum()), lags)


def square_correlation(e: Array, u: Array, lags: NDArray[np.int64]) -> Correlation:
    """Of the residual's square with the input's: what first-order tests are blind to."""
    x, y = standardised(e), standardised(u)
    known = np.isfinite(e)
    squared = np.where(known, x**2, np.nan)
    return _against(standardised(squared), standardised(y**2), int(known.sum()), lags)


def _against(x: Array, y: Array, n: int, lags: NDArray[np.int64]) -> Correlation:
    size = float(np.linalg.norm(x) * np.linalg.norm(y))
    if size <= 0.0 or n < 8:
        return Correlation(lags, np.zeros(len(lags)), np.ones(len(lags)))
    values = _products(y, x)[lags] / size
    return Correlation(lags, values, np.full(len(lags), _limit(len(lags)) * bartlett_std(x, y, n)))


def bartlett_std(x: Array, y: Array, n: int) -> float:
    """Standard deviation of the correlation of two independent series with these autocorrelations."""
    longest = max(len(x) // 10, 1)
    taper = 1.0 - np.arange(longest) / longest
    rx, ry = _products(x, x)[:longest], _products(y, y)[:longest]
    rx, ry = rx / max(rx[0], 1e-300), ry / max(ry[0], 1e-300)
    total = 1.0 + 2.0 * float(np.sum((taper * rx * ry)[1:]))
    return float(np.sqrt(max(total, 1.0) / max(n, 1)))


def _limit(count: int) -> float:
    """Normal deviate that none of `count` lags exceeds with probability 1 - CHANCE (Bonferroni)."""
    return float(ndtri(1.0 - 0.5 * CHANCE / max(count, 1)))


def _products(a: Array, b: Array) -> Array:
    """Sums over k of a[k] b[k + lag], for lags 0 to n - 1."""
    n = len(a)
    size = 1 << (2 * n - 1).bit_length()
    whole: Array = np.fft.irfft(np.conj(np.fft.rfft(a, size)) * np.fft.rfft(b, size), size)[:n]
    return whole
