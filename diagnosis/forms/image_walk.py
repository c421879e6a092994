"""An image that strays as a random walk does: a tracker that loses its place a little at every frame.

    r_k = w_k + e_k,   w_k = stay w_{k-1} + drive,   stay close to 1

How well that foretells an image from the images before it is held against white noise. The log score of evidence.py
cannot tell: it takes a rest with any spectrum for a discrepancy that every model may have, and a walk is no more than
such a spectrum. So the walk has to be the whole of it: what it leaves from image to image is white in all bands, and it
lasts for much longer than the arm swings. A course of knots then stands for the walk in the fit.
"""

from math import inf

import numpy as np

from stillarm.diagnosis.data.noise import MATTERS_OF_NOISE
from stillarm.diagnosis.fitting.band_score import SHAPES, log_density, spectra
from stillarm.diagnosis.fitting.evidence import CONVINCING_NATS, PRICE_NATS
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.cause import Form
from stillarm.diagnosis.forms.courses import Walk, of_walk, walk_that_lasts
from stillarm.diagnosis.physics.computing import Lately
from stillarm.diagnosis.sensors.late_bursts import Wander, wander_of

_NUMBERS = 3  # of the law: how far, for how long, and the noise
_LASTS_SWINGS = 4.0  # of the arm, that a walk is remembered at least: what is quicker may be the arm
_RETURNS = 20.6
"""A walk is remembered for more than the recording's length over this: one that goes where it will seems to return
sooner once in a hundred times (Dickey and Fuller 1979: the bias of the regression on the last value, with a mean). A
tracker has lost where it was; what returns, such as a tip in gusts, is held by something."""
# nats that the innovations' bands may tell: of what the walk gains; at least
_OF_GAIN, _BY_CHANCE = 0.05, 20.0
_MOST_FORETOLD = 0.5  # of a walk's deviation, left of it at most: a quarter of its power
_WANDERS: Lately[bytes, Wander | None] = Lately(8)
"""By what a fit leaves in the images: it is asked for as terms, as nats, and beside each of some rivals."""


def image_walk(last: Fit) -> Walk | None:
    """The walk that a fit leaves in the images; None where there is none, or it is not the whole of what is left."""
    wander = _wander_in(last)
    if wander is None:
        return None
    period_s = last.world.step_s("displacement")
    lasts_s = -period_s / np.log(wander.stay)
    if lasts_s * last.value("modes.0.frequency_hz") < _LASTS_SWINGS:
        return None
    if lasts_s * _RETURNS < last.world.measured.duration_s:
        return None
    if wander.std < MATTERS_OF_NOISE * wander.noise_std:
        return None
    gain = wander.nats - wander.white_nats - PRICE_NATS * _NUMBERS
    if gain <= 0.0 or _told_by_bands(wander, period_s) > max(_OF_GAIN * gain, _BY_CHANCE):
        return None
    return walk_that_lasts(float(lasts_s), wander.std, float(gain))


def is_foretold(last: Fit, other: Fit) -> bool:
    """Whether another fit gives what strays a reason, such as a lens or the joint (`nats_ahead`)."""
    return nats_ahead(last, other) >= 0.0


def nats_ahead(last: Fit, other: Fit) -> float:
    """By how much likelier the images are with what another fit says of them than with the walk that this one leaves.
    The other's rest is white noise; or, where it takes the most of the walk away, a walk too, and the likelier one by
    far: a walk goes anywhere, and where a few numbers foretell most of where it went, it was none. The rest may be a
    pull that nobody has found. A fit that leaves the walk as it is does not count."""
    walk, rest = _wander_in(last), _wander_in(other)
    if walk is None or rest is None:
        return -inf
    most = rest.std < _MOST_FORETOLD * walk.std and rest.nats > walk.nats + CONVINCING_NATS
    return max(rest.white_nats, rest.nats if most else -inf) - walk.nats


def _wander_in(last: Fit) -> Wander | None:
    images = last.channel("displacement")
    return None if images is None else _WANDERS.of(images.off.tobytes(), lambda: wander_of(images.off))


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


FORM: Form = of_walk("tracking_drift", "rate_px_per_s", "displacement", "strayed image", image_walk)
