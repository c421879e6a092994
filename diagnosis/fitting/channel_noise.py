"""The noise of a channel: whatever the model, with its colour or as if it were white; and what matters beside it."""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data import robust
from stillarm.diagnosis.data.noise import MATTERS_AT_LEAST, MATTERS_OF_MOTION
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.fitting.evidence import noise_spectrum
from stillarm.diagnosis.fitting.fitted import THIN, Fit, least_level

Array = NDArray[np.float64]

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
    return max(robust.white_noise(residual), least)


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
