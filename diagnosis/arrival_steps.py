"""Where the arrivals step for good, beside a delay that wanders: the law of the wander learnt with the step in.

A step that is not in the model makes the wander seem quicker and larger than it is, and such a wander then explains
the step. So each law (stillarm.diagnosis.noise) is tried with a step before each frame, by its likelihood, a
level and a trend
fitted beside it.
"""

from dataclasses import dataclass
from math import log

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from stillarm.diagnosis.fit import WANDER_S, Fit
from stillarm.diagnosis.noise import Colour, wander_colours

Array = NDArray[np.float64]

_FEWEST = 60
SIDE = 15
"""Frames on either side of a step."""

_SURE_NATS = 5.0  # beyond what the best of so many places gains by chance


@dataclass(frozen=True)
class ArrivalStep:
    """The likeliest step of the arrivals. index: of the first frame after it; step_s: later by, s, with its standard
    deviation; nats: gained."""

    index: int
    step_s: float
    std_s: float
    nats: float


def step_of_arrivals(last: Fit) -> ArrivalStep | None:
    """The step that a fit's arrivals show beside a wander of the delay; None where they were not measured, or show
    none."""
    arrivals = last.channel("arrival")
    if arrivals is None:
        return None
    return arrival_step(arrivals.off, WANDER_S / last.world.step_s("arrival"))


def arrival_step(residual: Array, longest_frames: float) -> ArrivalStep | None:
    """The step that the residual arrivals (s, NaN where unknown) show, if one does. longest_frames: of a wander."""
    known = np.flatnonzero(np.isfinite(residual))
    n = len(known)
    if n < _FEWEST:
        return None
    r = residual[known] - float(np.median(residual[known]))
    none, best, place, size, doubt = -np.inf, -np.inf, 0, 0.0, 0.0
    for colour in wander_colours(longest_frames):
        plain, stepped, steps, stds = _likelihoods(r, colour)
        none = max(none, plain)
        at = int(np.argmax(stepped))
        if stepped[at] > best:
            best, place, size, doubt = float(stepped[at]), at, float(steps[at]), float(stds[at])
    gained = best - none
    return ArrivalStep(int(known[place]), size, doubt, gained) if gained > log(n) + _SURE_NATS else None


def _likelihoods(r: Array, colour: Colour) -> tuple[float, Array, Array, Array]:
    """Profile log-likelihood without a step, and with one before each frame; each one's size, and its standard
    deviation. A level and a trend are fitted beside it."""
    n = len(r)

    def white(values: Array) -> Array:
        out: Array = lfilter([1.0, -colour.stay], [1.0, -colour.moving], values)
        return out

    design, _ = np.linalg.qr(np.stack((white(np.ones(n)), white(np.linspace(-1.0, 1.0, n))), axis=1)[1:])
    values = white(r)[1:]
    values = values - design @ (design.T @ values)
    # a step before frame k is the filter's answer to a step, k frames late: all its products are one filter run back
    answer = white(np.ones(n))
    along = _back(values, answer)
    squares = np.cumsum(answer**2)[n - 2 :: -1]
    shares = np.stack([_back(column, answer) for column in design.T])
    norms = np.maximum(squares - np.sum(shares**2, axis=0), 1e-12 * n)
    left = float(values @ values)
    gains = along**2 / norms
    gains[:SIDE] = gains[-SIDE:] = 0.0
    stepped = -0.5 * n * np.log(np.maximum(left - gains, 1e-12 * left + 1e-300))
    plain = -0.5 * n * log(max(left, 1e-300))
    stds = np.sqrt(np.maximum(left - gains, 0.0) / n / norms)
    first = np.zeros(1)  # a step before the first frame is none
    return (
        plain, np.concatenate((first - np.inf, stepped)), np.concatenate((first, along / norms)),
        np.concatenate((first, stds)),
    )  # fmt: skip


def _back(values: Array, answer: Array) -> Array:
    """Inner products of values with `answer` begun at each of their places."""
    n = len(values)
    size = 1 << (2 * n - 1).bit_length()
    spectrum = np.fft.rfft(values, size) * np.conj(np.fft.rfft(answer[:n], size))
    return np.asarray(np.fft.irfft(spectrum, size)[:n], dtype=np.float64)
