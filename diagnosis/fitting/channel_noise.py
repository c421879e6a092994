"""The noise of a channel: whatever the model, with its colour or as if it were white; and what matters beside it."""

from math import inf, log, sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data import robust
from stillarm.diagnosis.data.noise import MATTERS_AT_LEAST, MATTERS_OF_MOTION
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.fitting.evidence import noise_spectrum
from stillarm.diagnosis.fitting.fitted import THIN, Fit, least_level

Array = NDArray[np.float64]

_SEGMENT, _FEWEST_SEGMENTS = 64, 6
"""Values of a segment of a spectrum, and segments that tell one: a resonance of 2 % damping is narrower than a few of
its 32 frequencies."""
_AT_LIMIT, _OFTEN = 1e-6, 0.01  # of a limit; of the samples, which no noise has at one value


def noise_of(last: Fit, name: str, split: Split) -> float:
    """A channel's own noise, whatever the model, with its colour; not below what a simulation reaches."""
    white, many = white_noise(last, name), THIN.get(name, 1)
    count, level = noise_spectrum(last, name, split, white / sqrt(many))
    return sqrt(many * float(count @ level) / float(count.sum())) if count.sum() > 0.0 else white


def least_that_matters(last: Fit, name: str) -> float:
    """What a rest in a channel has to exceed, beside half the noise, to matter (contract.md), in the channel's unit."""
    return max(MATTERS_AT_LEAST.get(name, 0.0), MATTERS_OF_MOTION * last.world.variation(name))


def white_noise(last: Fit, name: str) -> float:
    """A channel's white noise: by fourth differences of its residual, not below what a simulation reaches; of the
    arrivals what their law says is usual."""
    residual = last.residuals[name]
    least = least_level(last.world, name) or 1e-12
    if name == "arrival":
        return max(last.sigma[name], last.world.model.timing.capture_delay_std_s, least)
    if name == "acceleration":
        residual = np.where(at_a_limit(last), np.nan, residual)
    noise = robust.white_noise(residual)
    if name == "displacement":  # what the arm's higher modes do is as fast as the images
        noise = min(noise, _floor(residual))
    return max(noise, least)


def _floor(residual: Array) -> float:
    """Standard deviation of white noise as loud as the upper half of a residual's spectrum is at most of its
    frequencies for most of the time: what rings there stands out at a few. Medians over segments that overlap by half
    (Welch 1967), of which those of white noise are log 2 of the means; infinite where there are too few."""
    if len(residual) < _SEGMENT:
        return inf
    taper = np.hanning(_SEGMENT)
    segments = np.lib.stride_tricks.sliding_window_view(residual, _SEGMENT)[:: _SEGMENT // 2]
    segments = segments[np.isfinite(segments).all(axis=1)]
    if len(segments) < _FEWEST_SEGMENTS:
        return inf
    power = np.abs(np.fft.rfft(taper * segments)) ** 2 / float(np.sum(taper**2))
    upper = np.median(power, axis=0)[_SEGMENT // 4 : -1]
    return sqrt(float(np.median(upper)) / log(2.0))


def at_a_limit(last: Fit) -> NDArray[np.bool_]:
    """Where an accelerometer is at a limit, by what it reads or by what it should: a limit cuts the noise off, too."""
    name = "acceleration"
    return _pinned(last.world.channels[name]) | _pinned(last.predicted.channels[name])


def _pinned(reading: Array) -> NDArray[np.bool_]:
    """Where an accelerometer reads its own largest value or its least, if it does so often: at a limit it has no noise.
    reading: m/s^2, (n,), NaN where unknown."""
    at_limit = np.zeros(len(reading), bool)
    for limit in (np.nanmax(reading), np.nanmin(reading)):
        there = np.abs(reading - limit) <= _AT_LIMIT * abs(limit)
        if there.mean() > _OFTEN:
            at_limit |= there
    return at_limit
