"""Samples of the accelerometer that are far off: single ones, as spikes are, or the tops of pulses that last."""

from dataclasses import dataclass
from math import log, pi, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from stillarm.diagnosis.fit import Data, Fit
from stillarm.diagnosis.quantities import RANGE
from stillarm.diagnosis.robust import std_about_median
from stillarm.diagnosis.unpredictable import unpredictable

Array = NDArray[np.float64]

SURE_NATS = 6.0
"""From here on outliers are taken for pulses, or for strikes."""

_OUTLYING = 6.0  # robust deviations
_OF_TWO = (0.0, 0.25, 0.5, 0.75, 1.0)  # shares
_NOISE, _NEVER = 2.0, 1e-12  # deviations; a density below which no sample says more
_AT_THE_LIMIT, _FEWEST_SAMPLES = 0.9, 100
_STEEP_SHARE, _STEEP_SAMPLES = 0.5, 3
_BEGUN_S = 0.01
_CROWD_SAMPLES, _CROWD = 12, 4
_TURNING, _BEFORE_S, _AFTER_S = 1e-3, 0.02, 0.06  # of the largest speed; about the instant it turns


@dataclass(frozen=True)
class Outliers:
    """The accelerometer's residual, m/s^2; which of it counts; its level; its size over its doubt; what stands out."""

    residual: Array
    known: NDArray[np.bool_]
    sigma: float
    u: Array
    flags: NDArray[np.bool_]


def outliers(data: Data, last: Fit) -> Outliers | None:
    """Samples that stand out in small number; None where too few are known."""
    sensor = last.channel("acceleration")
    if sensor is None:
        return None
    predicted, residual = sensor.predicted, sensor.off
    known = np.isfinite(residual) & within_range(last)
    known &= ~unpredictable(data, last)[data.blocks_of("acceleration")] & ~_just_begun(data)
    if known.sum() < _FEWEST_SAMPLES:
        return None
    sigma = std_about_median(residual[known]) + 1e-12
    doubt = np.hypot(sigma, _STEEP_SHARE * _steepness(predicted))
    u = np.nan_to_num(residual) / doubt
    far = np.abs(u) > _OUTLYING
    return Outliers(residual, known, sigma, u, known & far & ~_crowded(far))


def within_range(last: Fit) -> NDArray[np.bool_]:
    """Which samples of the accelerometer lie well within its range: at its limit it scatters less. (n,)"""
    limit = _AT_THE_LIMIT * last.value(RANGE)
    sensor = last.channel("acceleration")
    if sensor is None:
        return np.zeros(last.world.measured.cycles, bool)
    result: NDArray[np.bool_] = (np.abs(sensor.measured) < limit) & (np.abs(sensor.predicted) < limit)
    return result


def pulses(data: Data, found: Outliers | None) -> Array | None:
    """Nats of each block that its outliers are pulses of several samples, which no cause has a name for; None where
    there are none. (blocks,)"""
    if found is None or not found.flags.any():
        return None
    tops = np.flatnonzero(tops_of(found))
    gains = pulse_gains(np.where(found.known, found.u, np.nan), tops)
    return np.bincount(data.blocks_of("acceleration")[tops], gains, len(data.split.held)).astype(np.float64)


def tops_of(found: Outliers) -> NDArray[np.bool_]:
    """The largest of each few that stand out beside each other: one for each spike, or pulse. (n,)"""
    size = np.where(found.flags, np.abs(found.u), 0.0)
    before, after = np.append(0.0, size[:-1]), np.append(size[1:], 0.0)
    result: NDArray[np.bool_] = found.flags & (size > before) & (size >= after)
    return result


def pulse_gains(u: Array, tops: NDArray[np.int64]) -> Array:
    """Log-likelihood that each top is a pulse's over that it is a spike, by its two neighbours. (tops,)

    A spike is one sample or two: at least one neighbour is noise. Beside the top of a pulse both are anything up to it.
    How many spikes are two samples is not known: the share that speaks most for spikes is taken.
    u: residual over its level, (n,); an unknown neighbour says nothing. tops: the largest sample of each.
    """
    top = np.abs(u[tops])
    sign = np.sign(u[tops])
    before, after = sign * u[np.maximum(tops - 1, 0)], sign * u[np.minimum(tops + 1, len(u) - 1)]
    quiet_before, quiet_after = _normal(before), _normal(after)
    raised_before, raised_after = _up_to(top, before), _up_to(top, after)
    one = quiet_before * quiet_after
    two = 0.5 * (quiet_before * raised_after + raised_before * quiet_after)
    pulse = np.log(raised_before * raised_after + _NEVER)
    known = np.isfinite(before + after)
    laws = [
        np.where(known, pulse - np.log((1.0 - share) * one + share * two + _NEVER), 0.0) for share in _OF_TWO
    ]
    return min(laws, key=lambda gains: float(gains.sum()))


def strikes(flags: NDArray[np.bool_], joint_speed: Array, cycle_s: float) -> bool:
    """Whether what stands out gathers where the joint begins to turn the other way: a gear strikes there as it crosses
    its play, within a cycle or two, and no sensor's noise knows of it.

    Against as large a share of them there as of the time (log-likelihood ratio of two binomial laws). flags and
    joint_speed: (n,), the speed in rad/s.
    """
    turning = np.flatnonzero(np.abs(joint_speed) > _TURNING * float(np.max(np.abs(joint_speed), initial=0.0)))
    begun = turning[1:][np.diff(np.sign(joint_speed[turning])) != 0.0]
    near = np.zeros(len(flags), bool)
    for cycle in begun:
        near[max(0, cycle - round(_BEFORE_S / cycle_s)) : cycle + round(_AFTER_S / cycle_s)] = True
    of_time, count, there = float(near.mean()), int(flags.sum()), int(flags[near].sum())
    if not count or not 0.0 < of_time < 1.0 or there <= of_time * count:
        return False
    share = there / count
    nats = there * log(share / of_time)
    nats += (count - there) * log((1.0 - share) / (1.0 - of_time)) if there < count else 0.0
    return nats > SURE_NATS


def _normal(u: Array) -> Array:
    density: Array = np.exp(-0.5 * u**2) / sqrt(2.0 * pi)
    return density


def _up_to(top: Array, u: Array) -> Array:
    """Density of what lies anywhere between nothing and the top, but for the noise."""
    return np.where((u > -_NOISE) & (u < top + _NOISE), 1.0 / (top + 2.0 * _NOISE), 0.0)


def _just_begun(data: Data) -> NDArray[np.bool_]:
    """Samples just after the start or an impact: what the sensor's filter still holds of the time before is not known,
    and an impact's instant is, to the cycle only."""
    world = data.world
    found = np.zeros(world.measured.cycles, bool)
    for cycle in (0, *world.impacts):
        begin = max(cycle - 1, 0)
        found[begin : cycle + round(_BEGUN_S / world.measured.cycle_s)] = True
    return found


def _steepness(predicted: Array) -> Array:
    """Largest jump from sample to sample close by, less the slope that goes on: where the motion jumps, an instant that
    is slightly off makes a residual that is no spike."""
    change = np.abs(np.diff(predicted, 2, prepend=predicted[0], append=predicted[-1]))
    return np.asarray(maximum_filter1d(change, 2 * _STEEP_SAMPLES + 1), dtype=np.float64)


def _crowded(flags: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Flags among several others: a stretch that the simulation gets wrong, not single samples."""
    near = np.convolve(flags.astype(float), np.ones(2 * _CROWD_SAMPLES + 1), "same")
    crowd: NDArray[np.bool_] = near >= _CROWD
    return crowd
