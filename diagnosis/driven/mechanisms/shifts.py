"""By how much a sensor shows late what the simulation says: where a fit of its delay is to begin."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def best_shift(measured: Array, simulated: Array, longest: int) -> int:
    """By how many samples `simulated` is to be delayed (negative: advanced), at most `longest`, to look most like
    `measured`: where their correlation is largest. Both (n,); NaN counts as the mean.
    """
    one, other = (np.nan_to_num(values - np.nanmean(values)) for values in (measured, simulated))
    size = 2 * len(one)  # no end meets the other's beginning
    spectrum = np.fft.rfft(one, size) * np.conj(np.fft.rfft(other, size))
    correlation = np.fft.irfft(spectrum, size)
    longest = min(longest, len(one) - 1)
    shifts = np.arange(-longest, longest + 1)
    return int(shifts[np.argmax(correlation[shifts])])
