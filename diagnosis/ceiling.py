"""An accelerometer at its limit: samples that pile up at one size, on both sides, or stay there while it moves on."""

from dataclasses import replace
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.measured import Measured
from stillarm.diagnosis.noise import log_likelihood

Array = NDArray[np.float64]

_CLOSE = 0.9
_LEVELS = np.linspace(1.0, 0.7, 61)  # of the largest sample
_LEAST_NATS, _LEAST_OF_A_PEAK = 20.0, 3.0
_FLAT, _FLAT_ALONE, _SURE = 0.4, 0.25, 2.0  # of the motion's own slope; deviations of it
_STEPS, _FEWEST_SAME, _MOSTLY = 3.0, 6, 0.8  # of a converter, in the noise; samples; of them
_BEYOND, _FEWEST, _FEWEST_PEAKS = 1.0, 8, 2  # deviations; samples; separate stretches


def ceiling_of(acceleration: Array, noise: float) -> float | None:
    """The size at which they pile up, m/s^2, if more lie about it than anywhere above a fifth of it. noise: m/s^2."""
    values = np.abs(acceleration[np.isfinite(acceleration)])
    counts, edges = np.histogram(values, bins=40)
    top = int(np.argmax(counts[8:])) + 8
    if counts[top] < 0.05 * len(values) or counts[top] < 1.5 * counts[top // 2]:
        return None
    level = float(np.median(values[(values >= edges[top]) & (values <= edges[top + 1])]))
    return level if level > 2.0 * noise else None


def below(measured: Measured, ceiling: float) -> Measured:
    """The recording without the samples that lie near the limit: what they say of the motion is wrong."""
    kept = np.where(np.abs(measured.acceleration) < _CLOSE * ceiling, measured.acceleration, np.nan)
    return replace(measured, acceleration=kept)


def plateau_of(acceleration: Array, predicted: Array, noise: float) -> float | None:
    """The size at which the sensor stays, m/s^2, at each peak that the simulation has larger; None where it does not,
    or follows the motion there: a gain that is off, or a stiffness, has no such flat top. One peak alone has to be
    quite flat, or to show a converter's last value.

    A few peaks after one impact tell, wherever they lie: the level is that of all data. All: (n,), m/s^2; noise: m/s^2.
    """
    known = np.isfinite(acceleration)
    shown, due = np.where(known, np.abs(acceleration), 0.0), np.where(known, np.abs(predicted), 0.0)
    if _same_again(shown, due, noise):
        return float(shown.max())
    gains = [_gain(shown, due, float(level), noise) for level in _LEVELS * float(shown.max())]
    best = int(np.argmax([float(gain.sum()) for gain in gains]))
    level, gain = float(_LEVELS[best] * shown.max()), gains[best]
    beyond = due > level + _BEYOND * noise
    if gain.sum() < _LEAST_NATS or beyond.sum() < _FEWEST:
        return None
    starts = np.flatnonzero(np.diff(np.concatenate(([False], beyond)).astype(np.int64)) == 1)
    peaks = int(np.sum(np.add.reduceat(np.where(beyond, gain, 0.0), starts) > _LEAST_OF_A_PEAK))
    by, of = due[beyond] - due[beyond].mean(), shown[beyond] - shown[beyond].mean()
    size = float(by @ by)
    if peaks < _FEWEST_PEAKS:
        return level if float(by @ of) + _SURE * noise * sqrt(size) < _FLAT_ALONE * size else None
    return level if float(by @ of) < _FLAT * size else None


def _same_again(shown: Array, due: Array, noise: float) -> bool:
    """Whether the largest reading comes again and again where the simulation is as large: a converter's last value, if
    it has many within the noise."""
    values = np.unique(shown)
    again = shown == values[-1]
    fine = len(values) > 1 and noise > _STEPS * float(np.min(np.diff(values)))
    return (
        fine
        and int(again.sum()) >= _FEWEST_SAME
        and float(np.mean(due[again] > values[-1] - noise)) > _MOSTLY
    )


def _gain(shown: Array, due: Array, level: float, noise: float) -> Array:
    """Nats of each sample by a sensor that stays at that level, (n,)."""
    clipped, plain = shown - np.minimum(due, level), shown - due
    return log_likelihood(clipped / noise, noise) - log_likelihood(plain / noise, noise)
