"""Laws without a name, held against a finding on its own ground: in free run, with a state of their own making.

Free terms (stillarm.diagnosis.forms.freeform) are forces over the state of a fit. Where that fit is far from what
the arm did, as a baseline is where the arm's frequency goes with its deflection, they are forces over a wrong state,
and no rival of a law that makes its own.
"""

from math import acos, pi, sqrt

import numpy as np

from stillarm.common.causes import RIVALS
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.fitting.evidence import PRICE_NATS, score
from stillarm.diagnosis.fitting.fit import fit, slopes_of
from stillarm.diagnosis.fitting.fitted import Fit, carried_over, make_data
from stillarm.diagnosis.fitting.gains import free_names
from stillarm.diagnosis.forms.freeform import DRIVE, Free, Group
from stillarm.diagnosis.forms.sensor_walk import IMAGE_WALK, IMAGES, nats_ahead
from stillarm.diagnosis.physics.copies import shared_out
from stillarm.diagnosis.search.candidates import Candidate
from stillarm.diagnosis.search.refits import QUICK

_CUBIC, _CUBIC_SIZE = "cubic_stiffness", "arm.cubic_per_m2"
_LAW = "one_sided_stiffness"
_SHARE, _AT = f"{_LAW}.share", f"{_LAW}.at_m"
_FREE = (_SHARE, _AT)
_BEGINS = (0.05, 0.3, 0.6)
"""Of the usual amplitude, where the other stiffness begins: a fit moves it on from the nearest."""
_MOST_PART = 0.9  # a law that begins at the amplitude's very end changes no frequency
_USUAL = 0.9  # quantile of the deflection that stands for its amplitude: the frequency there is to be the finding's


def rival_law(first: Candidate, before: Fit, split: Split) -> Free | None:
    """The best law without a name in the place of a finding, if it does better; None where it does not, or none is of
    the finding's kind. before: the fit on which the finding was taken."""
    if first.cause == _CUBIC:
        return _one_sided(first, before, split)
    if (first.cause, first.form) == (IMAGE_WALK.id, IMAGE_WALK.name):
        return _driven(first, before, split)
    return None


def _driven(first: Candidate, before: Fit, split: Split) -> Free | None:
    """A joint that no sensor shows, and whose speed is off by a function of it, in the place of images that walk. A
    walk's merit is not that of the log score, by which free terms are held against any other finding."""
    world = DRIVE.world(before)
    if world is None:
        return None
    amounts = world.added[-1].amounts
    names = free_names(before, world, amounts)
    start = carried_over(before, world)
    fitted = fit(make_data(world, split), start, names, iterations=QUICK, colour=before.colour)
    ahead = nats_ahead(before, fitted, IMAGES) - PRICE_NATS * len(amounts)
    return Free(DRIVE, first.merit + ahead, "displacement", fitted) if ahead > 0.0 else None


def _one_sided(first: Candidate, before: Fit, split: Split) -> Free | None:
    """A stiffness that is another beyond a deflection to one side, in the place of a cubic one."""
    world = before.world
    data, cubic = make_data(world, split), first.fit.value(_CUBIC_SIZE)
    began = world.space.with_values(carried_over(first.fit, world), {_CUBIC_SIZE: before.value(_CUBIC_SIZE)})
    if first.begins is not None:  # a force that is not the same to both sides is none before either
        began = world.space.with_values(began, {first.begins: before.value(first.begins)})
    names = free_names(before, world, _FREE)
    slopes = slopes_of(first.fit)
    usual = float(np.quantile(np.abs(first.fit.predicted.motion.q[:, 0]), _USUAL))
    starts = [
        world.space.with_values(began, {_SHARE: _as_stiff(cubic, usual, part), _AT: side * part * usual})
        for side in (1.0, -1.0)
        for part in _BEGINS
    ]
    tried = shared_out(
        lambda start: fit(data, start, names, iterations=QUICK, colour=before.colour, known=slopes),
        starts,
        (world,),
    )
    was = score(before, split)
    best = max(tried, key=lambda one: float(score(one, split).gain(was).sum()))
    best = fit(data, best.vector, names, colour=before.colour)
    gains = score(best, split).gains(was)
    merit = sum(gains.values()) - PRICE_NATS * len(_FREE)
    if merit < first.merit or merit < _from_there(first, best, before, split):
        return None
    group = Group(_LAW, RIVALS[_LAW].name, lambda fit: {})
    return Free(group, merit, max(gains, key=lambda name: gains[name]), best, gains)


def _from_there(first: Candidate, rival: Fit, before: Fit, split: Split) -> float:
    """The finding's merit where it is fitted from where its rival is: a search may have left it at a worse place, which
    says nothing of the two laws."""
    usual = float(np.quantile(np.abs(rival.predicted.motion.q[:, 0]), _USUAL))
    part = min(abs(rival.value(_AT)) / usual, _MOST_PART)
    cubic = rival.value(_SHARE) / _as_stiff(1.0, usual, part)
    world = first.fit.world
    idle = {_SHARE: before.value(_SHARE), _AT: before.value(_AT)}
    start = world.space.with_values(carried_over(rival, world), idle | {_CUBIC_SIZE: cubic})
    anew = fit(make_data(world, split), start, first.fit.free, colour=before.colour)
    return float(score(anew, split).gain(score(before, split)).sum()) - PRICE_NATS * len(first.free)


def _as_stiff(cubic_per_m2: float, amplitude_m: float, part: float) -> float:
    """The share by which a stiffness beyond a part of an amplitude, to one side, changes the frequency as a cubic one
    does: by the mean of force times cos over a swing (harmonic balance) 3/8 c A^2, and share / 2 pi (acos p - p
    sqrt(1 - p^2))."""
    of_one = (acos(part) - part * sqrt(1.0 - part**2)) / (2.0 * pi)
    return 0.375 * cubic_per_m2 * amplitude_m**2 / of_one
