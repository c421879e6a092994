"""A sensor whose reading strays as a random walk does: a tracker that loses its place a little at every frame, an
accelerometer whose zero creeps with its temperature.

    r_k = w_k + e_k,   w_k = stay w_{k-1} + drive,   stay close to 1

How well that foretells a reading from those before it is held against white noise. The log score of evidence.py cannot
tell: it takes a rest with any spectrum for a discrepancy that every model may have, and a walk is no more than such a
spectrum. So the walk has to be the whole of it: what it leaves from reading to reading is white in all bands, and it
lasts for much longer than the arm swings. A course of knots then stands for the walk in the fit.

A channel that is much quicker than that is read now and then (`_reading`).
"""

from functools import partial
from math import inf, sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.noise import MATTERS_OF_NOISE
from stillarm.diagnosis.fitting.band_score import SHAPES, log_density, spectra
from stillarm.diagnosis.fitting.evidence import CONVINCING_NATS, PRICE_NATS
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.cause import Form
from stillarm.diagnosis.forms.courses import Walk, of_walk, walk_that_lasts
from stillarm.diagnosis.physics.computing import Lately
from stillarm.diagnosis.sensors.late_bursts import Wander, wander_of

Array = NDArray[np.float64]

IMAGES, BIAS = "displacement", "acceleration"  # channels that are looked at
_NUMBERS = 3  # of the law: how far, for how long, and the noise
_LASTS_SWINGS = 4.0  # of the arm, that a walk is remembered at least: what is quicker may be the arm
_RETURNS = 20.6
"""A walk is remembered for more than the recording's length over this: one that goes where it will seems to return
sooner once in a hundred times (Dickey and Fuller 1979: the bias of the regression on the last value, with a mean). A
tracker has lost where it was; what returns, such as a tip in gusts, is held by something."""
# nats that the innovations' bands may tell: of what the walk gains; at least
_OF_GAIN, _BY_CHANCE = 0.05, 20.0
_MOST_FORETOLD = 0.5  # of a walk's deviation, left of it at most: a quarter of its power
_READ_S, _MEAN_S, _QUICK_S = 0.1, 0.02, 0.005
"""How often a channel that is quicker than the last is read, by its mean over how long. A quarter of what the course of
knots follows: whether a sensor strays by itself from one millisecond to the next is no matter."""
_WANDERS: Lately[bytes, Wander | None] = Lately(16)
"""By what a fit leaves in a channel: it is asked for as terms, as nats, and beside each of some rivals."""


def walk_in(last: Fit, channel: str) -> Walk | None:
    """The walk that a fit leaves in a channel; None where there is none, or it is not the whole of what is left."""
    wander = _wander_in(last, channel)
    if wander is None:
        return None
    every, many = _every(last, channel)
    period_s = every * last.world.step_s(channel)
    lasts_s = -period_s / np.log(wander.stay)
    if lasts_s * last.value("modes.0.frequency_hz") < _LASTS_SWINGS:
        return None
    if lasts_s * _RETURNS < last.world.measured.duration_s:
        return None
    if wander.std < MATTERS_OF_NOISE * sqrt(many) * wander.noise_std:
        return None
    gain = wander.nats - wander.white_nats - PRICE_NATS * _NUMBERS
    if gain <= 0.0 or _told_by_bands(wander, period_s) > max(_OF_GAIN * gain, _BY_CHANCE):
        return None
    return walk_that_lasts(float(lasts_s), wander.std, float(gain))


def nats_ahead(last: Fit, other: Fit, channel: str) -> float:
    """By how much likelier a channel is with what another fit says of it than with the walk that this one leaves. The
    other's rest is white noise; or, where it takes the most of the walk away, a walk too, and the likelier one by far:
    a walk goes anywhere, and where a few numbers foretell most of where it went, it was none. The rest may be a pull
    that nobody has found. A fit that leaves the walk as it is does not count."""
    walk, rest = _wander_in(last, channel), _wander_in(other, channel)
    if walk is None or rest is None:
        return -inf
    most = rest.std < _MOST_FORETOLD * walk.std and rest.nats > walk.nats + CONVINCING_NATS
    return max(rest.white_nats, rest.nats if most else -inf) - walk.nats


def is_foretold(last: Fit, other: Fit, channel: str) -> bool:
    """Whether another fit gives what strays a reason, such as a lens, the joint, or gravity along a sensor's axis."""
    return nats_ahead(last, other, channel) >= 0.0


def _wander_in(last: Fit, channel: str) -> Wander | None:
    reading = _reading(last, channel)
    return None if reading is None else _WANDERS.of(reading.tobytes(), lambda: wander_of(reading))


def _reading(last: Fit, channel: str) -> Array | None:
    """What a fit leaves in a channel, read every so many values, NaN where none of them is known; None where it was not
    measured."""
    shown = last.channel(channel)
    if shown is None:
        return None
    every, many = _every(last, channel)
    parts = shown.off[: len(shown.off) // every * every].reshape(-1, every)[:, :many]
    known = np.isfinite(parts)
    count = known.sum(axis=1)
    return np.where(count > 0, np.where(known, parts, 0.0).sum(axis=1) / np.maximum(count, 1), np.nan)


def _every(last: Fit, channel: str) -> tuple[int, int]:
    """Values of a channel from one reading to the next, and of which a reading is the mean."""
    step_s = last.world.step_s(channel)
    return (round(_READ_S / step_s), round(_MEAN_S / step_s)) if step_s < _QUICK_S else (1, 1)


def _told_by_bands(wander: Wander, period_s: float) -> float:
    """By how many nats the innovations are likelier by a level for each band of frequency than by one for all."""
    every = np.zeros(len(wander.innovations), np.int64)
    by_bands = spectra(wander.innovations, period_s, every, 1, 0.0)
    count, power = by_bands.count, by_bands.power
    seen = count[0] > 0.0
    own = power[:, seen] / count[:, seen]
    common = np.full_like(own, power[0].sum() / count[0].sum())
    told = [log_density(count[:, seen], power[:, seen], level, SHAPES[-1]).sum() for level in (own, common)]
    return float(told[0] - told[1])


IMAGE_WALK: Form = of_walk(
    "tracking_drift", "rate_px_per_s", IMAGES, "strayed image", partial(walk_in, channel=IMAGES)
)
BIAS_WALK: Form = of_walk(
    "accelerometer_bias_drift", "rate_m_s3", BIAS, "strayed bias", partial(walk_in, channel=BIAS)
)
