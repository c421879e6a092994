"""Linear least squares in many short windows of a channel, compiled: one window takes microseconds, as long as NumPy
takes to look at its arguments.

By Householder's reflections with the largest column first (Golub and Van Loan, Matrix Computations, section 5.4.2): a
column that lies within those before it, to a small part of the largest, is left out.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


@njit(cache=True, nogil=True, error_model="numpy")
def _largest(both: Array, j: int, k: int) -> int:
    """The column from j to k that is largest from row j on."""
    best, at = -1.0, j
    for c in range(j, k):
        size = 0.0
        for i in range(j, both.shape[0]):
            size += both[i, c] * both[i, c]
        if size > best:
            best, at = size, c
    return at


@njit(cache=True, nogil=True, error_model="numpy")
def _reflect(both: Array, j: int, alpha: float) -> None:
    """Reflect all columns after j so that column j, from row j on, would be alpha in row j and nothing below."""
    both[j, j] -= alpha
    size = 0.0
    for i in range(j, both.shape[0]):
        size += both[i, j] * both[i, j]
    for c in range(j + 1, both.shape[1]):
        dot = 0.0
        for i in range(j, both.shape[0]):
            dot += both[i, j] * both[i, c]
        dot *= 2.0 / size
        for i in range(j, both.shape[0]):
            both[i, c] -= dot * both[i, j]


@njit(cache=True, nogil=True, error_model="numpy")
def least_squares(both: Array, least: float, amounts: Array) -> float:
    """Fill in the amounts, (k,), of which terms @ amounts is nearest to the values, and return what that leaves,
    squared.

    both: (n, k + 1), the terms and then the values; overwritten. least: of the largest term, below which what the
    others leave of one is nothing; its amount is zero then.
    """
    n, k = both.shape[0], both.shape[1] - 1
    order, diagonal = np.arange(k), np.zeros(k)
    rank, top = 0, 0.0
    for j in range(min(n, k)):
        pivot = _largest(both, j, k)
        norm = 0.0
        for i in range(j, n):
            norm += both[i, pivot] * both[i, pivot]
        norm = np.sqrt(norm)
        top = max(top, norm)
        if norm <= least * top:
            break
        order[j], order[pivot] = order[pivot], order[j]
        for i in range(n):
            both[i, j], both[i, pivot] = both[i, pivot], both[i, j]
        diagonal[j] = -norm if both[j, j] > 0.0 else norm
        _reflect(both, j, diagonal[j])
        rank += 1
    amounts[:] = 0.0
    for j in range(rank - 1, -1, -1):
        rest = both[j, k]
        for c in range(j + 1, rank):
            rest -= both[j, c] * amounts[order[c]]
        amounts[order[j]] = rest / diagonal[j]
    left = 0.0
    for i in range(rank, n):
        left += both[i, k] * both[i, k]
    return left


@njit(cache=True, nogil=True, error_model="numpy")
def swings_in_windows(
    time_s: Array, values: Array, forced: Array, beside: Array, places: NDArray[np.int64], firsts: NDArray[np.int64],
    starts_s: Array, w: float, damping: float, least: float, left: Array, swing: Array,
) -> None:  # fmt: skip
    """What a vibration at w, rad/s, and what goes along with it leave of a channel in each window.

        values = e (a cos w t + b sin w t) + c forced + d + beside @ f,    e = exp(-damping w t)

    time_s, values, forced: (n,); beside: (n, m). places, firsts: the samples of window i are
    places[firsts[i]:firsts[i + 1]]; starts_s: (windows,) when t is zero. Fills in left, (windows,): the mean square of
    what is left, NaN where there are fewer than twice as many samples as terms; and swing, (windows,): the deviation of
    the first three terms' sum.
    """
    many = beside.shape[1] + 4
    amounts = np.empty(many)
    for window in range(len(starts_s)):
        first, after = firsts[window], firsts[window + 1]
        n = after - first
        if n < 2 * many:
            left[window], swing[window] = np.nan, 0.0
            continue
        both, kept = np.empty((n, many + 1)), np.empty((n, 3))
        power = 0.0
        for i in range(n):
            place = places[first + i]
            t = time_s[place] - starts_s[window]
            fade = np.exp(-damping * w * t)
            both[i, 0], both[i, 1], both[i, 2] = fade * np.cos(w * t), fade * np.sin(w * t), forced[place]
            both[i, 3] = 1.0
            for j in range(many - 4):
                both[i, 4 + j] = beside[place, j]
            for j in range(3):
                kept[i, j] = both[i, j]
            both[i, many] = values[place]
            power += values[place] ** 2
        rest = least_squares(both, least, amounts)
        left[window] = (rest + 1e-12 * power) / n + 1e-30
        mean = square = 0.0
        for i in range(n):
            one = kept[i, 0] * amounts[0] + kept[i, 1] * amounts[1] + kept[i, 2] * amounts[2]
            mean += one
            square += one * one
        swing[window] = np.sqrt(max(square / n - (mean / n) ** 2, 0.0))
