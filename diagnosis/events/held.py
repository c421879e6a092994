"""Where something holds the arm aside: a swing cancels over whole periods, a bend that holds stays.

The images are compared with the arm's answer to its joint alone, without any impact. A ring-down cancels in means over
whole periods, twice taken, to some (2 z)^2 of itself; a force that holds bends the arm by q = f / w^2, which does not.
A pull ends where the arm is let go: there the bend is gone, and an impact stands that sets the arm ringing.
"""

from collections.abc import Sequence
from math import ceil

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.robust import MIN_USUAL, std_about_zero, white_noise
from stillarm.diagnosis.fitting.departures import stretches
from stillarm.diagnosis.fitting.fitted import Fit

Array = NDArray[np.float64]

_LEAST_S = 0.2  # over which the bend is averaged, twice
_UNEVEN = 0.03  # of the swings: by how much the mean may miss them, of which the square is left of a swing
_MOST_SWINGS = 6  # of a mean: a pull that is shorter than they are is not told
_COVERED = 0.95  # of a mean's images are known: a part of a swing does not cancel
_HELD = 5.0  # times the usual bend, in which one mean in a million lies by chance
_OF_TOP = 0.05  # of its largest bend: down to there a pull that rises slowly is followed back
_MARGIN = 0.25  # of the mean's width, before it was seen to begin and after it was seen to end
_PLAIN = 3.0  # times the white noise, that a pull leaves of the images
_SHORTEST_S = 0.25  # a push is shorter
_LET_GO = 0.5  # of the bend is left, at the middle of the mean's fall
_BEFORE = 0.6  # of the mean's width, that a pull lasts: a shorter one is like the beginning of a swing
_ABOUT = 0.75  # of the mean's width, from there to the impact


def held_spans_s(last: Fit) -> tuple[tuple[float, float], ...]:
    """Spans in which something held the arm until it was let go, from and to, s, each with an impact near its end."""
    seen = bend(last)
    if seen is None:
        return ()
    time, bent, width_s = seen
    usual = max(std_about_zero(bent), 1e-12)
    struck = [cycle * last.world.measured.cycle_s for cycle in last.world.impacts]
    spans = []
    for first, after in stretches(np.abs(bent) > _HELD * usual):
        top = float(np.max(np.abs(bent[first:after])))
        strong = np.flatnonzero(np.abs(bent[first:after]) > _LET_GO * top)
        ends = float(time[first + strong[-1]])
        begins = _begins(time, bent, first, max(_OF_TOP * top, usual))
        # a swing that begins bends the arm too, from half the mean's width before its impact on
        near = [
            one for one in struck if abs(one - ends) < _ABOUT * width_s and one - begins > _BEFORE * width_s
        ]
        if near and ends - begins > max(_SHORTEST_S, 0.5 * width_s):
            margin = _MARGIN * width_s
            spans.append((max(begins - margin, 0.0), max(*near, ends) + margin))
    left = [one for span in spans for one in _outside(span, last.world.unjudged_s)]
    return tuple(one for one in left if _departs(last, one))


def _departs(last: Fit, span: tuple[float, float]) -> bool:
    """Whether the images depart from the fit in a span, with its impacts: a free swing that begins at one bends the arm
    too, until its first is over."""
    images = last.channel("displacement")
    if images is None:
        return False
    time = last.world.instants(last.vector)
    inside = images.off[(time >= span[0]) & (time < span[1])]
    return bool(np.nanmean(inside**2) > (_PLAIN * white_noise(images.off)) ** 2)


def _outside(span: tuple[float, float], others: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """A span without what lies in others; none where it ends in one, or little is left."""
    start, end = span
    if any(a < end <= b for a, b in others):
        return []
    start = max([start, *(b for a, b in others if a < end and b > start)])
    return [(start, end)] if end - start > _SHORTEST_S else []


def bend(last: Fit) -> tuple[Array, Array, float] | None:
    """When, s, and by how much, px, the arm was bent to one side, both (n,), and the width of the mean, s; None without
    images."""
    images = last.channel("displacement")
    if images is None:
        return None
    world = last.world
    still = {
        name: 0.0 for name in world.space.place if name.startswith("jump.") and not name.startswith("jump.0.")
    }
    shown = world.predict(world.space.with_values(last.vector, still)).channels.get("displacement")
    if shown is None:
        return None
    off = images.measured - shown
    known = np.isfinite(off)
    if known.sum() < MIN_USUAL:
        return None
    off = np.where(known, off - np.median(off[known]), 0.0)  # what is left out already bends nothing
    step_s = world.step_s("displacement")
    swings = _whole_swings(1.0 / (last.value("modes.0.frequency_hz") * step_s), _LEAST_S / step_s)
    over = np.full(swings, 1.0 / swings)
    mean = np.convolve(np.convolve(off, over, "same"), over, "same")
    whole = np.convolve(np.convolve(known.astype(np.float64), over, "same"), over, "same") > _COVERED
    mean = np.where(whole, mean - np.median(mean[whole]), 0.0) if whole.any() else np.zeros(len(mean))
    return world.instants(last.vector), mean, 2.0 * swings * step_s


def _whole_swings(images: float, least: float) -> int:
    """The number of images nearest to a whole number of swings. images: in a swing; least: images."""
    first = max(1, ceil(least / images))
    for many in range(first, first + _MOST_SWINGS):
        if abs(many * images - round(many * images)) < _UNEVEN * many * images:
            return round(many * images)
    return round(first * images)


def _begins(time: Array, bent: Array, first: int, least: float) -> float:
    """When a bend that is plain from the image `first` on began, down to a bend of that size, s."""
    sign = np.sign(bent[first])
    while first > 0 and sign * bent[first - 1] > least:
        first -= 1
    return float(time[first])
