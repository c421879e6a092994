"""Whether a candidate is more than chance, and more than a model's usual discrepancy: what it takes to be a finding."""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.common.causes import CAUSES as DECLARED
from stillarm.diagnosis.data.noise import MATTERS_OF_NOISE
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.fitting.channel_noise import noise_of
from stillarm.diagnosis.fitting.evidence import CONVINCING_NATS
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.force_terms import own_frequencies_hz
from stillarm.diagnosis.physics.computing import OutOfTime
from stillarm.diagnosis.search.candidates import Candidate, turns_the_joint

Array = NDArray[np.float64]

LEAST_OF_NOISE = 0.15
"""Least effect with a name, of a channel's noise: what the model's discrepancy may be anyhow."""

FORETOLD_NATS = 3.0
"""Least that a finding gains in the blocks that it was not fitted to: odds of 20 to 1 that it foretells anything. With
the levels of all blocks: where the held-out ones are louder, those of the others say nothing of how well."""

ALWAYS_THERE = "second_bending_mode"
"""Every arm has more modes than its model has: one is named where it matters (contract.md)."""

_OF_A_STEP = 0.5  # of what arrivals are foretold otherwise, from one to the next
_OF_LASTING = 0.3
"""Of how much later images come, counts as an effect: a delay wanders by half its scatter whatever is wrong."""
_STRAYING = 1.5
"""Times the stated deviation of the delay: what goes further is no usual wander, of which a recording as long as it
lasts tells the deviation to a third or so (contract.md: a slow wander within the stated spread is normal)."""
_BLOCKS_OF_AN_EVENT = 2  # of the recording: in which it lies, or across whose edge it rings
# parts of the recording: what goes wrong with the joint acts at the tops of its motion, or at its turns, and matters if
# it does in one of them
_TENTHS = 10
# of a mode's frequency: some widths of the resonance of an arm with a damping ratio of 0.01 to 0.02
_NEAR_A_MODE = 0.1


def convinces(one: Candidate, last: Fit, split: Split, beside: bool) -> bool:
    """Whether a candidate is more than chance and more than a model's usual discrepancy, and within its bounds.
    beside: a finding there is already: what does not matter beside it is told as left, unless that took over what
    matters by itself. Nor is a form that may set in at any instant named where it does not matter: with a model that is
    a little off, one of many does."""
    if one.merit < CONVINCING_NATS or not _within_bounds(one):
        return False
    if one.law is not None:
        return True
    if float(one.nats[split.held].sum()) < FORETOLD_NATS or _is_of_an_event(one):
        return False
    if beside or _is_anyhow(one, last):
        if size_in_noise(last, one.fit, split) > MATTERS_OF_NOISE:
            return True
        return not _is_anyhow(one, last) and size_alone(one, split) > MATTERS_OF_NOISE
    parts = _TENTHS if turns_the_joint(one.cause) else 1
    return size_in_noise(last, one.fit, split, parts) > LEAST_OF_NOISE


def is_too_little(one: Candidate, last: Fit, split: Split) -> bool:
    """Whether a candidate is what a small departure of any arm from its model looks like, and is small."""
    return _is_anyhow(one, last) and size_in_noise(last, one.fit, split) <= MATTERS_OF_NOISE


def _is_anyhow(one: Candidate, last: Fit) -> bool:
    """Whether a form takes a part of any discrepancy."""
    return _is_in_every_arm(one) or is_of_free_form(one, last) or one.begins is not None


def is_of_free_form(one: Candidate, last: Fit) -> bool:
    """Whether a form takes any course: so it takes a part of any discrepancy in its channel as well."""
    return _adds_terms(one.fit, last)


def is_course(one: Candidate, last: Fit) -> bool:
    """Whether a form goes where it will over time: it follows whatever is slow enough, and some of the noise."""
    return any(group.over_time for group in one.fit.world.added[len(last.world.added) :])


def _adds_terms(fit: Fit, last: Fit) -> bool:
    return len(fit.world.added) > len(last.world.added)


def _is_of_an_event(one: Candidate) -> bool:
    """Whether a mode that every arm may have shows in a block or two alone: it takes what an event sets off, or what
    the model has wrong of the event."""
    if one.cause != ALWAYS_THERE:
        return False
    return one.merit - float(np.sort(one.nats)[-_BLOCKS_OF_AN_EVENT:].sum()) < CONVINCING_NATS


def _is_in_every_arm(one: Candidate) -> bool:
    return one.cause == ALWAYS_THERE or rings_with_a_mode(one)


def rings_with_a_mode(one: Candidate) -> bool:
    """Whether a force that a cause puts on the arm has the frequency of one of its modes, or of an overtone: the
    resonance makes every small error of the model look like that, such as a damping that wanders; a stiffness that is
    not quite the same to both sides, or grows a little, makes overtones."""
    if DECLARED[one.cause].acts != "force" or "frequency_hz" not in one.values:
        return False
    hz = one.values["frequency_hz"][0]
    return any(abs(hz / own - 1.0) < _NEAR_A_MODE for own in own_frequencies_hz(one.fit))


def size_in_noise(before: Fit, after: Fit, split: Split, parts: int = 1) -> float:
    """How much less is left in the channel that a cause mends most, over that channel's noise: rms over the recording,
    or over that one of so many equal parts of it in which it is largest."""
    return max(_mended(before, after, name, split, parts) for name in before.residuals)


def size_alone(one: Candidate, split: Split) -> float:
    """How much of what is foretold is a form's own, over the noise: the deviation of what it changes, all else as it
    is, in the channel in which it changes most; 0 where no time is left to work it out. What was found before may have
    taken over most of that, as a dead time does of an accelerometer's lag, so that little is left to mend. Arrivals are
    not asked."""
    fit, space = one.fit, one.fit.world.space
    own = (*one.free, *((one.begins,) if one.begins is not None else ()))
    idle = space.with_values(fit.vector, {name: space[name].start for name in own})
    try:
        without = fit.world.predict(idle)
    except OutOfTime:
        return 0.0
    changed = {
        name: fit.predicted.channels[name] - without.channels[name]
        for name in fit.residuals
        if name != "arrival"
    }
    return max(
        (float(np.nanstd(each)) / noise_of(fit, name, split) for name, each in changed.items()), default=0.0
    )


def _mended(before: Fit, after: Fit, name: str, split: Split, parts: int) -> float:
    """In one channel. What rounding makes is no noise: a fit of anything may take all of it, step^2 / 12. Of what lasts
    in the arrivals a wander of the delay takes the most: it counts by how much they are foretold otherwise, and a
    drift, which is what a delay that wanders looks like, no more than it is seen beside the wander, unless it goes
    further than the delay is stated to."""
    less = before.residuals[name] ** 2 - after.residuals[name] ** 2
    known = less[np.isfinite(less)]
    power = max((float(one.mean()) for one in np.array_split(known, parts) if len(one)), default=0.0)
    power -= before.world.resolution(name) ** 2 / 12.0
    seen = sqrt(max(power, 0.0))
    return (_lasting(before, after, seen) if name == "arrival" else seen) / noise_of(after, name, split)


def _lasting(before: Fit, after: Fit, seen_s: float) -> float:
    """By how much arrivals that are foretold otherwise count, s. seen_s: beside a wander of the delay, rms."""
    now, then = after.channel("arrival"), before.channel("arrival")
    if now is None or then is None:
        return 0.0
    otherwise = now.predicted - then.predicted
    otherwise = otherwise[np.isfinite(otherwise)]
    if len(otherwise) < 2:
        return 0.0
    lasting_s = _OF_LASTING * float(np.std(otherwise))
    beyond = _strays_beyond_stated(otherwise, before)
    drifts = not (beyond or _steps(otherwise) or _adds_terms(after, before))
    return min(seen_s, lasting_s) if drifts else lasting_s


def _strays_beyond_stated(arrivals_s: Array, last: Fit) -> bool:
    """Whether arrivals scatter further than the model states of the delay; not where it states nothing. arrivals_s:
    off what a fit foretells, NaN where unknown."""
    stated_s = last.world.model.timing.capture_delay_std_s
    return stated_s > 0.0 and float(np.nanstd(arrivals_s)) >= _STRAYING * stated_s


def _steps(later_s: Array) -> bool:
    """Whether most of it comes from one arrival to the next."""
    return bool(np.max(np.abs(np.diff(later_s))) >= _OF_A_STEP * np.ptp(later_s))


def _within_bounds(one: Candidate) -> bool:
    known = {parameter.name: parameter for parameter in DECLARED[one.cause].parameters}
    for name, (value, _) in one.values.items():
        parameter = known.get(name)
        if parameter is not None and parameter.kind in ("number", "whole"):
            slack = 1e-9 * max(abs(parameter.lowest), abs(parameter.highest))
            if not parameter.lowest - slack <= value <= parameter.highest + slack:
                return False
    return True
