"""Readings of the accelerometer that are not the arm's: single spikes, tops of pulses, strikes of a gear, a limit.

An accelerometer at its limit: samples that pile up at one size, on both sides, or stay there while it moves on.

Held-out blocks that nobody could have foretold are left out: an impact fell there, or just before, and what it shook
died away before the rest.
"""

from dataclasses import dataclass, replace
from math import log, pi, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.data.noise import HUBER, log_likelihood
from stillarm.diagnosis.data.robust import MIN_USUAL, OUTLYING, std_about_median
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.fitting.fitted import Data, Fit
from stillarm.diagnosis.physics.quantities import RANGE

Array = NDArray[np.float64]

SURE_NATS = 6.0
"""From here on outliers are taken for pulses, or for strikes: 400 to 1."""

_OF_TWO = (0.0, 0.25, 0.5, 0.75, 1.0)  # of spikes, that are two samples long: all are tried
_NOISE, _NEVER = 2.0, 1e-12  # deviations; a density below which no sample says more
# of a jump of the motion: an instant half a sample off; samples on either side in which one may have been
_STEEP_SHARE, _STEEP_SAMPLES = 0.5, 3
_BEGUN_S = 0.01  # after the start or an impact: what a sensor's filter holds of before is not known
_CROWD_SAMPLES, _CROWD = 12, 4  # samples on either side; flags among them, one's own with them, of a stretch
_TURNING, _BEFORE_S, _AFTER_S = 1e-3, 0.02, 0.06  # of the largest speed; about the instant it turns

# blocks that nobody could have foretold
_MISFIT = 2.0  # times the channel's variance, outliers bounded
_SHOWING = ("acceleration", "deflection", "displacement")

# a limit
_CLOSE = 0.9  # of it: from there on a reading, or the motion, may be at the limit
_LEVELS = np.linspace(1.0, 0.7, 61)  # of the largest sample
_LEAST_NATS, _LEAST_OF_A_PEAK = 20.0, 3.0  # gained by a limit, the best of 61; by a peak that counts, 20 to 1
_FLAT, _FLAT_ALONE, _SURE = 0.4, 0.25, 2.0  # of the motion's own slope; deviations of it
_STEPS, _FEWEST_SAME, _MOSTLY = 3.0, 6, 0.8  # of a converter, in the noise; samples; of them
_BEYOND, _FEWEST, _FEWEST_PEAKS = 1.0, 8, 2  # deviations; samples; separate stretches


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
    # a reading at the limit where none is foretold stands out like any other
    known = np.isfinite(residual) & (np.abs(predicted) < _CLOSE * last.value(RANGE))
    known &= ~unpredictable(data, last)[data.blocks_of("acceleration")] & ~_just_begun(data)
    if known.sum() < MIN_USUAL:
        return None
    sigma = std_about_median(residual[known]) + 1e-12
    doubt = np.hypot(sigma, _STEEP_SHARE * _steepness(predicted))
    u = np.nan_to_num(residual) / doubt
    far = np.abs(u) > OUTLYING
    return Outliers(residual, known, sigma, u, known & far & ~_crowded(far))


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


def unpredictable(data: Data, last: Fit) -> NDArray[np.bool_]:
    """Which blocks: the state after an impact is fitted to the training part alone, which knows nothing of a mode that
    has faded by then. Such a block's thousands of nats hang on the last digit of the first mode, and say nothing of
    any cause. (blocks,)"""
    split = data.split
    found = np.zeros(len(split.held), bool)
    for block in _struck(last, split):
        found[block] = any(
            _strays(last, name, data.held[name] & (data.blocks[name] == block))
            for name in _SHOWING
            if name in last.residuals
        )
    return found


def _struck(last: Fit, split: Split) -> list[int]:
    """Held-out blocks with an impact, or that begin within a period of the first mode after one: from less of it the
    training part does not tell how the arm rings on."""
    times = np.array(last.world.impacts, dtype=np.float64) * last.world.measured.cycle_s
    if not len(times):
        return []
    until = times + 1.0 / last.value("modes.0.frequency_hz")
    blocks = np.concatenate((split.blocks_of(times), split.blocks_of(until)))
    return [int(block) for block in np.unique(blocks) if split.held[block]]


def _strays(last: Fit, name: str, here: NDArray[np.bool_]) -> bool:
    """Whether a channel's mean square there is more than it may be."""
    u = np.clip(last.residuals[name][here] / last.sigma[name], -HUBER, HUBER)
    return bool(len(u)) and float(np.mean(u * u)) > _MISFIT


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
