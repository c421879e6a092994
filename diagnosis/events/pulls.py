"""Something unknown holds the arm for a while, or pushes it: what the arm shows meanwhile is not judged, as no model
foretells it.

A pull is seen in the images: it bends the arm to one side for longer than a part of a swing, and ends where the
vibration jumps. A push by hand lasts a part of a swing, with an impact as its best account: the sensors depart from the
model about that impact, and nowhere near it. From the end of either the arm rings from a state of its own.
"""

from collections.abc import Iterable, Sequence
from math import sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from stillarm.diagnosis.data.robust import MIN_USUAL, std_about_zero, white_noise
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.events.held import held_spans_s
from stillarm.diagnosis.events.impacts import ANEW, WHILE_SOUGHT, fit_with_impacts, pruned
from stillarm.diagnosis.events.jumps import PUSH_PERIODS
from stillarm.diagnosis.fitting.departures import (
    LOUD_OVER_S,
    as_loud_about,
    is_one_sided,
    long_stretch,
    loud_at,
    loud_stretch,
    stretches,
)
from stillarm.diagnosis.fitting.fit import CHANGED_NATS, fit
from stillarm.diagnosis.fitting.fitted import Fit, carried_over, make_data

Array = NDArray[np.float64]

_MOST_TURNS = 4  # in which pulls are looked for; after the second, those that hold over whole swings alone
_SOUGHT = 2  # times that pulls, and pushes, are looked for: what one leaves out shows the next
# a pull
_WINDOW_S = 0.2  # over which an image's departure is looked at
_GAP_S, _LEAD_S = 0.15, 0.3  # quiet within a pull; left out before a pull shows, as it begins below the noise
_SHORTEST_S, _LONGEST_S = 0.25, 8.0  # a push is shorter; nothing longer is looked for
_ONE_SIDED = 0.5  # of the departure's power beyond the noise is its mean's: a swing has none
_STRAYING = 0.5  # of the usual departure, that is left once images are seen from where they are for longer than a pull
_MOST = 0.3  # of the recording, that pulls leave unjudged: of more none is believed
_FURTHER = 3.0  # times the departure elsewhere: what stands out so is something of its own
_AT_NOISE = 1.5  # times the white noise: a rest below it has no effect in it that counts
_CLEARER = 0.8  # of the departure elsewhere, that is left of it: two fifths of its power were the span's

# a push
_PUSHED = ("acceleration", "displacement")  # channels that show it
_BESIDE_PERIODS = 1.0  # before and after it, the model holds
_WORSE = 1.02  # times the power that was left, in any channel: more, and a push is not left out
_HOLDS = 0.1  # of the time beside a push, that may depart from the model
# before and after an impact, in the images alone
_SPANS_PERIODS = ((0.5, 0.5), (1.0, 0.5), (0.5, 1.0), (1.0, 1.0))
_MOST_TRIED = 6  # impacts tried as pushes, in four spans each
_MOST_OF_ONE = 0.1  # of the recording, that a push may take


def without_pulls(baseline: Fit, split: Split) -> Fit:
    """The baseline with what held the arm for a while left out, and impacts sought once more: beside a pull none that
    is less than it shows. From the end of a pull the arm rings from a state of its own."""
    cycle_s = baseline.world.measured.cycle_s
    for turn in range(_MOST_TURNS):
        found = held_spans_s(baseline)
        if turn < _SOUGHT:
            found += tuple(one for one in pull_spans_s(baseline) if not _overlaps(one, found))
        found = tuple(one for one in found if not _is_a_move(one, baseline))
        known = baseline.world.unjudged_s
        # where the arm is held again before it has swung once, nothing tells the state from which it rings between
        unjudged_s = _merged((*known, *found), within_s=1.0 / baseline.value("modes.0.frequency_hz"))
        spans = [one for one in unjudged_s if one not in known]
        if not spans or _length_s(unjudged_s) - _length_s(known) > _MOST * baseline.world.measured.duration_s:
            break
        ends = {round(end / cycle_s) for _, end in spans if end < baseline.world.measured.duration_s}
        kept = {
            i
            for i in baseline.world.impacts
            if not any(a <= i * cycle_s < b - 2.0 * cycle_s for a, b in spans)
        }
        world = baseline.world.changed(impacts=tuple(sorted(kept | ends)), unjudged_s=tuple(unjudged_s))
        begun = carried_over(baseline, world)
        if not _stand_out(spans, baseline):
            names = world.baseline_names()
            without = fit(make_data(world, split), begun, names, iterations=WHILE_SOUGHT, anew=ANEW)
            if not _tells_the_rest(without, baseline):
                break
        baseline = fit_with_impacts(world, split, begun)
    return baseline


def _stand_out(spans: Sequence[tuple[float, float]], last: Fit) -> bool:
    """Whether the images depart from the model further in some spans than they do elsewhere. Without images a span is
    taken as it is."""
    images = last.channel("displacement")
    if images is None:
        return True
    known = np.isfinite(images.off)
    time, off = last.world.instants(last.vector)[known], images.off[known]
    inside = np.zeros(len(time), bool)
    for start, end in spans:
        inside |= (time >= start) & (time < end)
    rms = [float(np.mean(off[part] ** 2)) ** 0.5 if part.any() else 0.0 for part in (inside, ~inside)]
    return rms[0] > _FURTHER * rms[1]


def _tells_the_rest(without: Fit, before: Fit) -> bool:
    """Whether the images are told to their noise once some spans are left out, or plainly better than before: where
    they depart elsewhere just as they did, it was nothing in these spans."""
    seen, images = _power_where_both(without, before), without.channel("displacement")
    if seen is None or images is None:
        return True
    _, left, was = seen
    return sqrt(left) < max(_AT_NOISE * white_noise(images.residual), _CLEARER * sqrt(was))


def _is_a_move(span: tuple[float, float], last: Fit) -> bool:
    """Whether a span begins and ends as a move of the joint does: what bends the arm then is in the model's account of
    moves, and has to be explained."""
    measured = last.world.measured
    near_s = _LEAD_S + 1.0 / last.value("modes.0.frequency_hz")
    return any(
        abs(span[0] - begin * measured.cycle_s) < near_s and abs(span[1] - end * measured.cycle_s) < near_s
        for begin, end in stretches(measured.told_to_move)
    )


def _length_s(spans: Iterable[tuple[float, float]]) -> float:
    return sum(end - start for start, end in spans)


def _shared_s(span: tuple[float, float], others: Iterable[tuple[float, float]]) -> float:
    """How much of a span lies in others, s."""
    return sum(max(min(span[1], end) - max(span[0], start), 0.0) for start, end in others)


def _overlaps(span: tuple[float, float], others: Sequence[tuple[float, float]]) -> bool:
    return _shared_s(span, others) > 0.0


def without_pushes(baseline: Fit, split: Split) -> Fit:
    """The baseline with pushes left out. From the end of each the arm rings as from the impact that accounts for it."""
    for _ in range(_SOUGHT):
        spans = push_spans_s(baseline)
        if not spans:
            break
        found = _left_out(baseline, spans, split)
        if not _no_worse(found, baseline):
            break
        baseline = found
    if baseline.channel("acceleration") is None:
        baseline = _without_pushes_seen(baseline, split)
    return baseline


def _without_pushes_seen(baseline: Fit, split: Split) -> Fit:
    """The same of images alone, in which the arm rings long after a push as no impact has it: spans about an impact
    are tried, and the one is left out without which the rest is likeliest. An impact has any state after it already,
    so that a span left out mends nothing beyond it but what a force within it spoilt. A force that swings the arm for
    some periods spoils nothing beyond them, if an impact is found at its end: it shows as a stretch that departs from
    the model between times that do not."""
    period, cycle_s = 1.0 / baseline.value("modes.0.frequency_hz"), baseline.world.measured.cycle_s
    for cycle in baseline.world.impacts[:_MOST_TRIED]:
        struck = cycle * cycle_s
        if any(start <= struck <= end for start, end in baseline.world.unjudged_s):
            continue
        spans = [
            (max(struck - before * period, 0.0), struck + after * period) for before, after in _SPANS_PERIODS
        ]
        tried = [_left_out(baseline, [span], split, quick=True) for span in spans]
        nats = [_nats_where_both(one, baseline) for one in tried]
        if max(nats) > CHANGED_NATS:
            baseline = _left_out(baseline, [spans[int(np.argmax(nats))]], split)
            continue
        span = _seen_about(baseline, struck, period)
        if span is None:
            continue
        without = _left_out(baseline, [span], split)
        ends = any(span[0] <= i * cycle_s <= span[1] for i in without.world.impacts)
        if ends and _no_worse(without, baseline):
            baseline = without
    return baseline


def _seen_about(baseline: Fit, struck: float, period: float) -> tuple[float, float] | None:
    """The stretch about an impact in which the images depart from the model, as a span, s; None unless it is short: a
    push that lasts swings the arm while it does, and the impact stands at its end."""
    stretch = long_stretch(baseline, struck)
    if stretch is None:
        return None
    start, end = max(stretch[0] - 0.5 * period, 0.0), max(stretch[1], struck) + 0.25 * period
    short = end - start < min(_LONGEST_S, _MOST_OF_ONE * baseline.world.measured.duration_s)
    return (start, end) if short else None


def _nats_where_both(found: Fit, before: Fit) -> float:
    """By how much likelier a fit makes the images that both judge, their noise level unknown."""
    seen = _power_where_both(found, before)
    if seen is None:
        return 0.0
    many, power, power_before = seen
    return 0.5 * many * float(np.log(power_before / max(power, 1e-300)))


def _power_where_both(found: Fit, before: Fit) -> tuple[int, float, float] | None:
    """How many images both fits judge, and the mean square that each leaves of them, px^2; None where none is."""
    now, then = found.channel("displacement"), before.channel("displacement")
    if now is None or then is None:
        return None
    off, was = now.residual, then.residual
    both = np.isfinite(off) & np.isfinite(was)
    if not both.any():
        return None
    return int(both.sum()), float(np.mean(off[both] ** 2)), float(np.mean(was[both] ** 2))


def _left_out(baseline: Fit, spans: Sequence[tuple[float, float]], split: Split, quick: bool = False) -> Fit:
    """The fit without what these spans show, and with one impact in each: a state to ring on from. quick: in the few
    steps that tell which span is the best."""
    world = baseline.world
    unjudged_s = tuple(_merged([*world.unjudged_s, *spans]))
    kept = set(world.impacts)
    for start, end in unjudged_s:
        inside = [i for i in world.impacts if start <= i * world.measured.cycle_s <= end]
        kept -= set(inside[:-1])
    there = world.changed(impacts=tuple(sorted(kept)), unjudged_s=unjudged_s)
    begun, data, names = carried_over(baseline, there), make_data(there, split), there.baseline_names()
    if quick:
        return fit(data, begun, names, colour=baseline.colour, iterations=WHILE_SOUGHT, anew=ANEW)
    return pruned(fit(data, begun, names, colour=baseline.colour), split)


def _no_worse(found: Fit, before: Fit) -> bool:
    """Whether a fit leaves no more where both are judged."""
    for name, off in found.residuals.items():
        was = before.residuals[name]
        both = np.isfinite(off) & np.isfinite(was)
        if not both.any():
            continue
        # a joint that is told far below the least level of its noise is told no better or worse there
        power = max(float(np.mean(was[both] ** 2)), before.sigma[name] ** 2)
        if np.mean(off[both] ** 2) > _WORSE * power:
            return False
    return True


def push_spans_s(last: Fit) -> tuple[tuple[float, float], ...]:
    """Spans in which something pushed the arm, from and to, s: about an impact the sensors depart from the model, and
    before and after it they do not."""
    world, period = last.world, 1.0 / last.value("modes.0.frequency_hz")
    spans = []
    by_usual = [loud_at(last, name) for name in _PUSHED]
    struck_s = [cycle * world.measured.cycle_s for cycle in world.impacts]
    ends_s = [end for _, end in world.unjudged_s]  # a pull, or a longer push, may not be over there
    for struck in (*struck_s, *ends_s):
        if any(start <= struck < end for start, end in world.unjudged_s):
            continue
        span = _push_about(last, struck, period, by_usual)
        if span is None:
            by_most = [as_loud_about(last, name, struck, period) for name in _PUSHED]
            span = _push_about(last, struck, period, by_most)
        if span is not None:
            spans.append(span)
    found = _merged(spans)
    more_s = _length_s(found) - sum(_shared_s(one, world.unjudged_s) for one in found)
    return () if more_s > _MOST * world.measured.duration_s else tuple(found)


def _push_about(
    last: Fit, struck: float, period: float, loud: Sequence[tuple[Array, NDArray[np.bool_]] | None]
) -> tuple[float, float] | None:
    """The span of a push about an impact, s, by when each channel was measured and is loud; None where it is none."""
    loudest = [
        (one, span)
        for one in loud
        if one is not None and (span := loud_stretch(*one, struck, period)) is not None
    ]
    if not loudest:
        return None
    start, end = min(a for _, (a, _) in loudest), max(b for _, (_, b) in loudest)
    # an image that is wrong for another reason is loud for long
    (time, flags), (since, until) = loudest[0]
    lasts = until - since - _shared_s((since, until), last.world.unjudged_s)
    if lasts - 2.0 * LOUD_OVER_S > PUSH_PERIODS * period:  # at either end it is seen over that
        return None
    if not _holds_beside(time, flags, (since, until), period):
        return None
    start, end = max(start, since - period), min(end, until + period)
    return max(start - LOUD_OVER_S, 0.0), end + LOUD_OVER_S


def _holds_beside(time: Array, loud: NDArray[np.bool_], span: tuple[float, float], period: float) -> bool:
    """Whether a channel is at its usual departure before and after a span."""
    start, end = span
    reach, margin = _BESIDE_PERIODS * period, 0.25 * period
    for a, b in ((start - reach, start - margin), (end + margin, end + reach)):
        beside = loud[(time >= a) & (time < b)]
        if len(beside) and np.mean(beside) > _HOLDS:
            return False
    return True


def pull_spans_s(last: Fit) -> tuple[tuple[float, float], ...]:
    """Spans in which something held the arm, from and to, s; each ends where the vibration jumps, or at none. Where
    none shows and the images stray, they are seen from where they are for longer than any pull lasts."""
    images = last.channel("displacement")
    if images is None or len(images.off) < MIN_USUAL:
        return ()
    known = np.isfinite(images.off)
    time, off = last.world.instants(last.vector)[known], images.off[known]
    rate = 1.0 / last.world.step_s("displacement")
    spans = _pulls_in(last, time, off, rate)
    if spans:
        return spans
    usual_over = min(round(2.0 * _LONGEST_S * rate), len(off) // 2)
    from_usual = off - median_filter(off, usual_over, mode="nearest")
    strays = std_about_zero(from_usual) < _STRAYING * std_about_zero(off)
    return _pulls_in(last, time, from_usual, rate) if strays else ()


def _pulls_in(last: Fit, time: Array, off: Array, rate: float) -> tuple[tuple[float, float], ...]:
    """The same in a departure of the images, px, that were exposed at `time`, s, so many a second."""
    width = max(3, round(_WINDOW_S * rate))
    loud, noise = is_one_sided(off, width), white_noise(off)
    spans = []
    cycle_s = last.world.measured.cycle_s
    for cycle in last.world.impacts:
        end = cycle * cycle_s
        start = _start(time, loud, end)
        if start is None or not _SHORTEST_S < end - start < _LONGEST_S:
            continue
        inside = off[(time >= start) & (time < end)]
        if len(inside) < 4 or np.mean(inside) ** 2 < _ONE_SIDED * (np.mean(inside**2) - noise**2):
            continue
        spans.append((max(start - _LEAD_S, 0.0), end))
    if _length_s(spans) > _MOST * last.world.measured.duration_s:
        return ()
    return tuple(_merged(spans))


def _start(time: Array, loud: NDArray[np.bool_], end: float) -> float | None:
    """Where the loud stretch that lasts until `end` began; None where there is none."""
    before = np.flatnonzero((time < end - 0.5 * _WINDOW_S) & (time > end - _LONGEST_S - 1.0))
    start, quiet_since = None, None
    for i in before[::-1]:
        if loud[i]:
            start, quiet_since = float(time[i]), None
            continue
        quiet_since = float(time[i]) if quiet_since is None else quiet_since
        if quiet_since - time[i] > _GAP_S:
            break
    return start


def _merged(spans: Iterable[tuple[float, float]], within_s: float = 0.0) -> list[tuple[float, float]]:
    """The spans in order, those that overlap as one, and those with so little between them."""
    found: list[tuple[float, float]] = []
    for start, end in sorted(spans):
        if found and start <= found[-1][1] + within_s:
            found[-1] = (found[-1][0], max(end, found[-1][1]))
        else:
            found.append((start, end))
    return found
