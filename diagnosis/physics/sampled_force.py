"""The input of a pair between its samples."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def upsampled(force: Array, factor: int) -> Array:
    """Band-limited interpolation of an input that was sampled, `factor` values a sample and one at the end.

    Taking it as held between samples would delay it by half a sample and hide a small nonlinearity. The ends are
    mirrored, so that they do not ring into each other.
    """
    n = len(force)
    pad = min(n - 1, 512)
    # odd reflection about both ends
    head = 2.0 * force[0] - force[pad:0:-1]
    tail = 2.0 * force[-1] - force[-2 : -pad - 2 : -1]
    whole = np.concatenate((head, force, tail))
    spectrum = np.fft.rfft(whole)
    if len(whole) % 2 == 0:
        spectrum[-1] *= 0.5  # half the sampling rate's own line is two lines of the finer spectrum
    fine = np.fft.irfft(spectrum, n=len(whole) * factor) * factor
    out = fine[pad * factor : (pad + n) * factor]
    return np.concatenate((out, [force[-1]]))
