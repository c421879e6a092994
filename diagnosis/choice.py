"""Which of the refitted causes is taken, and how surely: by what each predicts of the held-out part."""

from collections.abc import Callable, Mapping
from math import erf, inf, log, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stillarm.common.causes import CAUSES as CATALOGUE
from stillarm.diagnosis.candidate import Candidate, Found, Stage
from stillarm.diagnosis.catalogue import CAUSES
from stillarm.diagnosis.onset import AT_ONCE, ONSETS, onset_of
from stillarm.diagnosis.repeated_stamps import MOST_HELD
from stillarm.diagnosis.screen import Screening
from stillarm.diagnosis.worth import worth_a_name

Array = NDArray[np.float64]

LEAST_HELD_NATS = 3.0
_OVERLAP = 0.6
_LEAST_OF_A_LAW = 0.25
_LEAST_SHARE, _LEAST_SHARE_ELSEWHERE = 0.04, 0.01
_CLEARED, _MOSTLY_CLEARED = 0.2, 0.35  # of a channel's nats
_FAR_AHEAD = 0.5  # the next one's gain, of the best's
_STEADY = 4.0  # standard errors over blocks
_AS_MUCH = 0.2  # of a gain
_DISAGREE = 0.1
_TOLD_APART_NATS = 3.0
_SURE = 2.0  # standard errors
_NEARLY = 0.8  # of the held-out gain
_PLAINLY, _BY_TURNS = 2.0, 3.0  # of what a block may lose by chance; standard errors
_LOSSES = 0.1  # of all gains
_A_LITTLE = 0.05  # of the nats of the block that speaks most for a cause
_LIMITS = ("accelerometer_clipping", "drive_saturation")  # seen at the hardest moves and blows alone
_SAME_STEP = 3.0  # deviations: a delay that wanders is known less well than they say


class Rest(NamedTuple):
    """What is left of the data with a candidate, of what is left without it. nothing: whether that is all explained;
    share: that is left of the channel that the candidate clears."""

    nothing: bool
    share: float


ALL = Rest(nothing=False, share=1.0)


def rest(gain: float, without: Mapping[str, float], beside: Mapping[str, float]) -> Rest:
    """The rest, by the nats that are left in each channel without a candidate and beside it; all of the training part.
    A channel tells if at least half of what the candidate gains could come from there."""
    shares = [
        beside.get(name, 0.0) / nats
        for name, nats in without.items()
        if nats > 0.0 and nats - beside.get(name, 0.0) > 0.5 * gain
    ]
    return Rest(bool(without) and not beside, min(shares, default=1.0))


def next_to_take(
    stage: Stage,
    found: Found,
    rest_of: Callable[[Candidate], Rest] = lambda one: ALL,
    left_elsewhere: Callable[[], Mapping[str, float]] = dict,
) -> Candidate | None:
    """The stage's best that adds something of its own: no other name for what is already found, and no small change
    that a finding's simple form would leave of its true one.

    rest_of: what the data hold beside a candidate, of what they hold without it: as small as it may be, one that leaves
    nothing is no likeness of what a simple form leaves. left_elsewhere: nats that a finding's simple form leaves at
    most in other places, where something tells.
    """
    for one in [stage.taken, *stage.candidates] if stage.taken is not None else []:
        if not _convincing(one, stage.screening):
            continue
        larger = [each for each in found.findings if one.law is None and one.gain < _least_share(one, each)]
        if larger and not (
            _seen_before(one, stage, found)
            or _more_than_left(one, larger, left_elsewhere())
            or _stands_alone(one, stage, larger, rest_of(one))
        ):
            continue
        rivals = [earlier for earlier in found.stages if _same_thing(earlier, one)]
        if not rivals:
            return one
        for earlier in rivals:
            earlier.other_names.append(one.cause)
    return None


def _seen_before(one: Candidate, stage: Stage, found: Found) -> bool:
    """Whether it promised as much before anything was found: what is left of the first finding's true form was a small
    part then of the whole, of which a likeness would have taken far more."""
    before, now = found.stages[0].screening.promised(one.cause), stage.screening.promised(one.cause)
    return abs(before - now) < _AS_MUCH * now


def _more_than_left(one: Candidate, larger: list[Candidate], most: Mapping[str, float]) -> bool:
    """Whether it explains more in another place than the larger findings' simple forms can leave there."""
    return all(
        CATALOGUE[one.cause].place != CATALOGUE[each.cause].place and one.gain > most.get(each.cause, inf)
        for each in larger
    )


def _stands_alone(one: Candidate, stage: Stage, larger: list[Candidate], left: Rest) -> bool:
    """Whether a small one is there in its own right: nothing is left with it; or in another place than the larger
    findings it explains more than any other that convinces does, and that steadily, or leaves next to nothing of what
    it explains. A likeness explains a part of what a simple form leaves, here more and there less, and others a part of
    the same."""
    if left.nothing:
        return True
    if any(CATALOGUE[one.cause].place == CATALOGUE[each.cause].place for each in larger):
        return False
    others = [
        other.gain
        for other in stage.candidates
        if other.law is None and other is not one and _more_than_chance(other, stage.screening)
    ]
    next_gain = max(others, default=0.0)
    cleared = _MOSTLY_CLEARED if next_gain < _FAR_AHEAD * one.gain else _CLEARED
    steadily = one.held_out_std > 0.0 and one.held_out_gain > _STEADY * one.held_out_std
    return next_gain <= one.gain and (steadily or left.share < cleared)


def _least_share(one: Candidate, earlier: Candidate) -> float:
    """Nats that a finding's simple form may leave of its true one: in the same place more than elsewhere, and a
    sensor's none outside of its own channel. By all data: what is held out of a few hard moves may be any share of
    them."""
    here, there = CATALOGUE[one.cause].place, CATALOGUE[earlier.cause].place
    if here == there:
        return _LEAST_SHARE * earlier.gain
    return _LEAST_SHARE_ELSEWHERE * earlier.gain if there in ("arm", "drive") else 0.0


def _same_thing(earlier: Stage, one: Candidate) -> bool:
    """Whether a cause explained alone most of what was then taken, and adds little to it: one thing, two names."""
    taken = earlier.taken
    alone = next((c for c in earlier.candidates if c.cause == one.cause), None)
    if taken is None or alone is None or taken.law is not None or one.law is not None:
        return False
    return alone.gain > _OVERLAP * taken.gain and one.gain < _OVERLAP * alone.gain


def choose(ranked: list[Candidate], screening: Screening) -> Candidate | None:
    """The best that convinces: where that is too small to have a name, none but a law of noise or what shows in the
    arrivals, as what else does less well than it is no more than a likeness of the same."""
    small = too_small(ranked, screening)
    if small is not None:
        ranked = [one for one in ranked if one.law is not None or _by_arrivals(one, small)]
    return _best(ranked, screening)


def _by_arrivals(one: Candidate, small: Candidate) -> bool:
    """Whether a cause shows in the arrivals, of which one that is too small to have a name changes nothing."""
    return CATALOGUE[one.cause].place == "timing" and CATALOGUE[small.cause].place != "timing"


def too_small(ranked: list[Candidate], screening: Screening) -> Candidate | None:
    """The best, where its gain is more than chance, but its size too little to have a name."""
    best = _best(ranked, screening)
    return best if best is not None and not worth_a_name(best) else None


def _best(ranked: list[Candidate], screening: Screening) -> Candidate | None:
    """The best whose gain is more than chance; laws wait until there is no cause of another kind, as what a wrong
    simulation leaves looks like noise of another law: but not for one that explains far less than they do."""
    sure = [one for one in ranked if _more_than_chance(one, screening)]
    by_law = max((one.gain for one in sure if one.law is not None), default=0.0)
    sure.sort(
        key=lambda one: (
            one.law is None and one.gain < _LEAST_OF_A_LAW * by_law, not one.certain, one.law is not None,
        )
    )  # stable: the best first within each  # fmt: skip
    return _likelier(sure[0], sure) if sure else None


def _likelier(first: Candidate, convincing: list[Candidate]) -> Candidate:
    """The first, or one that predicts what is held out nearly as well, or as well as far as blocks can tell, and that
    all data together find likelier: what is held out is a third of them, and says whether, not always which."""
    tied = [one for one in convincing if one.certain == first.certain and _tie(first, one)]
    best = max(tied, key=_weight, default=first)
    return best if _weight(best) > _weight(first) + _TOLD_APART_NATS else first


def _tie(one: Candidate, other: Candidate) -> bool:
    """Whether the held-out part speaks for either of two causes by no more than twice its standard error over blocks,
    or by a small share of what both gain."""
    if one.law is not None or other.law is not None:
        return False
    difference = one.block_gains - other.block_gains
    lead = float(difference.sum()) + other.prior_penalty - one.prior_penalty
    few = (1.0 - _NEARLY) * max(one.held_out_gain, other.held_out_gain)
    return abs(lead) < max(_SURE * max(1.0, _spread(difference)), few)


def _weight(one: Candidate) -> float:
    """Nats gained in all data, less what its numbers, an onset among them, gain by being fitted."""
    onset = one.law is None and onset_of(CAUSES[one.cause]) is not None
    return one.gain - one.prior_penalty - 2.0 * len(one.fit.free) - (log(ONSETS) if onset else 0.0)


def in_doubt(chosen: Candidate | None, ranked: list[Candidate]) -> bool:
    """Whether nothing convinces, or what is held out speaks against the cause that explains most: something strays."""
    if chosen is None or chosen.law is not None:
        return True
    if chosen.certain:
        return False
    most = max(one.train_gain for one in ranked if one.law is None)
    return chosen.train_gain < (1.0 - _DISAGREE) * most


def rank(candidates: list[Candidate]) -> list[Candidate]:
    """The best of each cause, best first."""
    best: dict[str, Candidate] = {}
    for candidate in candidates:
        rival = best.get(candidate.cause)
        if rival is None or candidate.train_gain > rival.train_gain:
            best[candidate.cause] = candidate
    return sorted(best.values(), key=lambda one: -_merit(one))


def _merit(one: Candidate) -> float:
    """Held-out gain, less what each number beyond the first costs, and what is unlikely before any data."""
    return one.held_out_gain - 1.0 * (max(len(one.free), 1) - 1) - one.prior_penalty


def _convincing(one: Candidate, screening: Screening) -> bool:
    """Whether the gain is more than chance, and the size enough to have a name."""
    return worth_a_name(one) and _more_than_chance(one, screening)


def _more_than_chance(one: Candidate, screening: Screening) -> bool:
    """Whether the gain is more than chance: on the part that was searched, and on the held-out part."""
    penalty = LEAST_HELD_NATS + 0.5 * len(one.free)
    onset = onset_of(CAUSES[one.cause]) if one.law is None else None
    if onset is not None:  # it may lie in the held-out part altogether
        seen = one.held_out_gain > 0.0 and one.gain > screening.threshold_nats + penalty
        return seen and (onset in AT_ONCE or _in_places(one, penalty)) and _plausible(one)
    # it may lie where it is held out, or where nothing is
    anywhere = one.held_out_gain > -penalty and one.gain > screening.threshold_nats + penalty
    if one.certain:
        return anywhere and _plausible(one)
    if anywhere and one.cause in _LIMITS and _at_extremes(one, penalty):
        return _plausible(one)
    return (
        one.train_gain > screening.threshold_nats
        and one.held_out_gain > penalty
        and (
            (one.law is not None and one.law.alone)
            or one.held_out_gain > one.held_out_std
            or _rarely_seen(one, penalty)
        )
        and not _spoken_against(one, penalty)
        and _plausible(one)
    )


def _at_extremes(one: Candidate, penalty: float) -> bool:
    """Whether a limit shows in several blocks, where the motion reaches it, and nothing speaks against it."""
    if not len(one.train_blocks):
        return False
    return _in_places(one, penalty) and not _contradicts(one.all_block_gains, penalty)


def _spoken_against(one: Candidate, penalty: float) -> bool:
    """Whether some block speaks plainly against the cause, and all together do not outweigh what they differ by: noise
    that is not as white as it was taken for, an encoder's rounding above all, gains and loses by turns. Not where what
    is lost is little: then they differ because some show far more of the cause than others."""
    if not len(one.train_blocks):
        return False
    gains = one.all_block_gains
    return (
        _loses_much(gains)
        and _contradicts(gains, _PLAINLY * penalty)
        and one.gain < _BY_TURNS * _sum_error(gains)
    )


def _loses_much(gains: Array) -> bool:
    """Whether what blocks lose is not little beside what others gain."""
    return -float(gains[gains < 0.0].sum()) > _LOSSES * float(gains[gains > 0.0].sum())


def by_all_blocks(gains: Array) -> bool:
    """Whether blocks, held out or not, speak for a cause in more than one place, and next to none against it: what
    grows towards both ends, as a clock's skew does, hardly shows in what is held out between them."""
    return not _loses_much(gains) and float(gains.sum() - gains.max()) > LEAST_HELD_NATS


def _sum_error(gains: Array) -> float:
    """Standard error of the blocks' sum."""
    return float(np.std(gains, ddof=1) * sqrt(len(gains)))


def _rarely_seen(one: Candidate, penalty: float) -> bool:
    """Whether the cause shows in few blocks, at the quickest moves or the hardest blows, of which one at most may lie
    where it is held out: the gain of all blocks exceeds its standard error, and none of them speaks against the cause,
    as some do against a likeness that is now right, now wrong."""
    if not len(one.train_blocks):
        return False
    gains = one.all_block_gains
    return one.gain > _sum_error(gains) and not _contradicts(gains, penalty) and _in_places(one, penalty)


def _contradicts(gains: Array, most: float) -> bool:
    """Whether a block speaks against a cause by more than that many nats, and more than another's size being a little
    off may cost it where the cause hardly shows."""
    return float(gains.min()) < -max(most, _A_LITTLE * float(gains.max()))


def _in_places(one: Candidate, penalty: float) -> bool:
    """Whether the gain is more than chance without the block that speaks most for it: what happened in one place only
    may be anything."""
    if not len(one.train_blocks):
        return True
    gains = one.all_block_gains
    return one.gain - float(gains.max()) > penalty


def _plausible(one: Candidate) -> bool:
    """Whether every parameter lies where the catalogue has it."""
    known = {parameter.name: parameter for parameter in CATALOGUE[one.cause].parameters}
    for name, (value, _) in one.values.items():
        parameter = known.get(name)
        if parameter is not None and parameter.kind in ("number", "whole"):
            slack = 1e-9 * max(abs(parameter.lowest), abs(parameter.highest))
            if not parameter.lowest - slack <= value <= parameter.highest + slack:
                return False
    return True


def confidence(stage: Stage) -> float:
    """Probability that the one taken is the right one: by its lead over the next, in standard errors over blocks."""
    taken = stage.taken
    if taken is None:
        return 0.0
    rivals = [one for one in stage.candidates if one.cause != taken.cause and _rivals(taken, one)]
    gain, spread = taken.held_out_gain, taken.held_out_std
    if taken.certain and len(taken.train_blocks):  # it may show where nothing is held out
        gain, spread = taken.gain, _spread(taken.all_block_gains)
    certain = 0.5 * (1.0 + erf((gain / max(spread, 1.0)) / sqrt(2.0)))
    if not rivals:
        return min(0.99, certain)
    rival = max(rivals, key=_merit)
    lead = _merit(taken) - _merit(rival)
    spread = max(_spread(taken.block_gains - rival.block_gains), 2.0)
    if lead < 0.0 and _tie(taken, rival):  # taken for what all data say, of which a third is held out
        lead, spread = _weight(taken) - _weight(rival), sqrt(3.0) * spread
    return float(min(0.99, certain * 0.5 * (1.0 + erf(lead / spread / sqrt(2.0)))))


def _rivals(taken: Candidate, other: Candidate) -> bool:
    """Whether two explain the same: beside one that the data plainly show, those that they do not explain something
    else."""
    return other.certain or not taken.certain


def _spread(difference: Array) -> float:
    """Standard error of a lead's sum over the blocks that tell anything."""
    return float(np.std(difference) * sqrt(max(int(np.count_nonzero(difference)), 1)))


def inseparable(stage: Stage) -> list[str]:
    """Causes that predict the held-out part as well as the one taken, as far as it can be told, or that are likelier
    by all data together."""
    taken = stage.taken
    if taken is None or taken.law is not None:
        return []
    near = ["stale_frame_buffer"] if _by_whole_frames(taken) else []
    for one in stage.candidates:
        if one.cause == taken.cause or one.law is not None or not _rivals(taken, one):
            continue
        difference = taken.block_gains - one.block_gains
        lead = float(difference.sum()) + one.prior_penalty - taken.prior_penalty
        train = taken.train_gain - one.train_gain + one.prior_penalty - taken.prior_penalty
        as_good = (lead < max(2.0, _spread(difference)) and train < 6.0) or lead + train < 0.0
        if (as_good and one.held_out_gain > 0.7 * taken.held_out_gain) or one.cause in stage.other_names:
            near.append(one.cause)
    return list(dict.fromkeys(near))


def _by_whole_frames(one: Candidate) -> bool:
    """Whether the frames' clock stepped on by as much as a queue that holds a frame more, or a few, would make it seem:
    nothing tells when a frame of a counting camera was ready."""
    world = one.fit.world
    if one.cause != "clock_step" or not world.frame_clock.counted:
        return False
    step, doubt = one.values["step_s"]
    whole = round(step * world.model.camera.frame_rate_hz)
    off = step - whole / world.model.camera.frame_rate_hz
    return 1 <= whole <= MOST_HELD and abs(off) < _SAME_STEP * doubt
