"""One round of the search after another: the best form that convinces is taken, and the next round looks at what it
leaves.

The forms that a score test finds worth a look are refitted, the best of them to the end, some with an onset; each is
worth the log score that it gains over all blocks (evidence.py), less what its numbers cost.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from stillarm.common.causes import CAUSES as DECLARED
from stillarm.diagnosis.data.channels import JOINT_CHANNELS
from stillarm.diagnosis.data.noise import MATTERS_OF_NOISE
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.decision.beginning_again import likelier_baseline, to_begin_again
from stillarm.diagnosis.decision.decide import fit_before, share_explained
from stillarm.diagnosis.fitting.channel_noise import white_noise
from stillarm.diagnosis.fitting.evidence import score
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import Fit, carried_over, make_data
from stillarm.diagnosis.fitting.gains import free_names
from stillarm.diagnosis.fitting.rest import anything_but_spikes_matters
from stillarm.diagnosis.forms.catalogue import forms
from stillarm.diagnosis.forms.cause import Form
from stillarm.diagnosis.physics.computing import OutOfTime
from stillarm.diagnosis.physics.measured_joint import departure_hz
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.search.begun import ground_of
from stillarm.diagnosis.search.candidates import (
    EXPLAINED,
    Candidate,
    Found,
    Stage,
    by_one_measure,
    explains_the_same,
    of_law,
    turns_the_joint,
)
from stillarm.diagnosis.search.carried import hinted, second_best
from stillarm.diagnosis.search.comparison import IN_REACH, LEFT_OUT, compared
from stillarm.diagnosis.search.convincing import convinces, is_too_little
from stillarm.diagnosis.search.refits import QUICK
from stillarm.diagnosis.search.stated_baseline import dated_by_another_swing
from stillarm.diagnosis.sensors.clocks import backward_steps
from stillarm.diagnosis.sensors.laws import LawFound, laws

MOST_CAUSES = 3  # rounds of the search, and its findings, at most: each costs a look at every form
_WHOLE = 3  # causes of the drive that are fitted to all channels
_OF_FRAMES = ("counter", "received_s", "started_s", "displacement_px", "captured_s")
_SENSORS = (("camera", "timing"), ("accelerometer",))  # places whose causes show in the same channels
_OF_JOINT = ("start.", "drive.")  # quantities that the joint alone shows


def explained(
    found: Found,
    split: Split,
    tick: Callable[[float, str], None],
    only: Sequence[str] | None,
    known: Sequence[LawFound],
    begun: Sequence[Stage] = (),
    first: Stage | None = None,
) -> Found:
    """The findings one after another, unless the first round came upon a likelier baseline, which is told alone, or
    with that round as a hint. begun: rounds that are made already; first: the first beside this baseline, if it is
    made, from which nothing is taken yet."""
    baseline = found.baseline
    if begun and (better := likelier_baseline(begun[0], baseline, split)) is not None:
        return Found(baseline, baseline, likelier=better)
    data = make_data(baseline.world, split)
    for law in (*known, *backward_steps(data)):
        one = of_law(baseline, law)
        found.findings.append(one)
        found.stages.append(Stage([], [one], one))
    for stage in begun:
        found.stages.append(stage)
        _take(stage, found, split)
    if begun and (again := to_begin_again(found, split)) is not None:
        return again
    for turn in range(len(begun), MOST_CAUSES):
        tick(turn / MOST_CAUSES, f"causes, round {turn + 1}")
        upstream = turn == 0 and joint_departs(found.final)
        try:
            made = first if not found.stages else _again(found, split)
            stage = made or one_round(found, split, only, upstream)
            if turn == 0 and (plain := likelier_baseline(stage, baseline, split)) is not None:
                return Found(baseline, baseline, likelier=plain)
            found.stages.append(stage)
            if stage.taken is None and upstream:
                stage = one_round(found, split, only, upstream=False)
                found.stages.append(stage)
        except OutOfTime:
            found.left_out.append(LEFT_OUT)
            break
        if found.findings:
            _telling_enough(stage, found, split)
        if stage.taken is None:
            break
        _take(stage, found, split)
        if (again := to_begin_again(found, split)) is not None:
            return again
    return replace(found, findings=_largest_first(found.findings))


def _largest_first(findings: list[Candidate]) -> list[Candidate]:
    """Findings with the one that tells most ahead of what the drive did, which is sought first wherever its own sensors
    show it. Laws are judged by other channels, and stay."""
    if not findings or findings[0].law is not None or not turns_the_joint(findings[0].cause):
        return findings
    first = max(findings, key=lambda one: one.merit if one.law is None else 0.0)
    return [first, *(one for one in findings if one is not first)]


def _settled(one: Candidate, split: Split) -> Candidate:
    """A finding fitted until no step gains anything: what suffices to compare forms may leave much to the baseline, of
    which the next round would make a finding. From the stated delay too, where the fit is a part of a swing off that:
    images that were told wrongly may have made it late by whole swings."""
    last = one.fit
    space, delay = last.world.space, "timing.capture_delay_s"
    starts = [last.vector]
    if dated_by_another_swing(last):
        starts.append(space.with_values(last.vector, {delay: space[delay].start}))
    data = make_data(last.world, split)
    try:
        fits = [fit(data, start, last.free, colour=last.colour) for start in starts]
    except OutOfTime:
        return one
    fitted = max(fits, key=lambda each: each.train_log_likelihood)
    more = score(fitted, split).gain(score(last, split))
    if float(more.sum()) <= 0.0:
        return one
    values = one.parameters_of(fitted) if one.parameters_of is not None else one.values
    return replace(one, fit=fitted, values=values, nats=one.nats + more, merit=one.merit + float(more.sum()))


def _take(stage: Stage, found: Found, split: Split) -> None:
    """Add what a round took to the findings."""
    assert stage.taken is not None
    if stage.taken.law is None:
        stage.taken = _settled(stage.taken, split)
        found.final = stage.taken.fit
    found.findings.append(stage.taken)


def one_round(found: Found, split: Split, only: Sequence[str] | None, upstream: bool) -> Stage:
    """One round. upstream: of the drive alone, where the joint departs: the arm is judged by the joint as measured, so
    that what the drive did is no matter of the arm's."""
    last, taken = found.final, {one.cause for one in found.findings}
    allowed = [one for one in forms(last.world) if one.id not in taken and (only is None or one.id in only)]
    if upstream:
        drive = [one for one in allowed if turns_the_joint(one.id)]
        screening, candidates = compared(_joint_alone(last, split), drive, split, found)
        candidates = [_of_the_whole(one, last, split) for one in _best_of_each(candidates)[:_WHOLE]]
    else:
        screening, candidates = [], []
        if found.findings and not anything_but_spikes_matters(last, split):
            judged_again = _convincing_elsewhere(found, split)
            # what was found may have taken over what a sensor does, or been so large that nobody looked at that
            sensors = [place for places in _SENSORS for place in places]
            judged_again |= {one.id for one in allowed if DECLARED[one.id].place in sensors}
            allowed = [one for one in allowed if one.id in judged_again]
        if allowed:
            candidates = _second_best(found, allowed, split)
            anew = _to_compare(candidates, allowed, found, split)
            if anew:
                screening, compared_now = compared(last, anew, split, found)
                candidates += compared_now
        try:
            known = laws(make_data(last.world, split), last, found.laws)
            found.laws = (last, known)
            candidates += [of_law(last, law) for law in known if law.cause not in taken]
        except OutOfTime:
            found.left_out.append("laws of noise and timing")
    ranked = _best_that_convinces(candidates, last, split, beside=bool(found.findings))
    return _taken_of(Stage(screening, ranked, None), found, split)


def _second_best(found: Found, allowed: Sequence[Form], split: Split) -> list[Candidate]:
    """What convinced in the round before beside the one that it took, refitted beside that; none where that round took
    a law, or looked at the drive alone."""
    taken = found.stages[-1].taken if found.stages else None
    if taken is None or taken.law is not None or _drive_alone_looked_at(found):
        return []
    named = {one.id for one in allowed}
    others = [one for one in _convincing_before(found, split) if one.cause in named]
    return second_best(found.final, others, allowed, split)


def _to_compare(
    carried: Sequence[Candidate], allowed: Sequence[Form], found: Found, split: Split
) -> Sequence[Form]:
    """The forms that are compared anew beside the second best of a round: all, where each of those leaves something
    that matters, or nothing was left that does. None otherwise, but for those of the same sensor as one that the
    round's first dwarfed: what gains far less than that is not fitted to its end, so that a rival as good may not have
    been seen."""
    enough = [one for one in carried if not anything_but_spikes_matters(one.fit, split)]
    if not enough or not anything_but_spikes_matters(found.final, split):
        return allowed
    best, taken = max(enough, key=lambda one: one.merit), found.stages[-1].taken
    side = next((places for places in _SENSORS if DECLARED[best.cause].place in places), ())
    if taken is None or best.merit > IN_REACH * taken.merit:
        return []
    return [one for one in allowed if DECLARED[one.id].place in side]


def with_hint(stage: Stage | None, found: Found, split: Split) -> Stage | None:
    """A round, if it is made, with what was found beside another baseline, if anything was, as one more candidate."""
    if stage is None or found.hint is None:
        return stage
    try:
        one = hinted(ground_of(found.final, split), found.hint.taken, forms(found.final.world))
    except OutOfTime:
        one = None
    if one is None:
        return stage
    ranked = _best_that_convinces([*stage.candidates, one], found.final, split, beside=bool(found.findings))
    return _taken_of(Stage(stage.screening, ranked, None), found, split)


def _again(found: Found, split: Split) -> Stage | None:
    """The round before once more, without the law that it took: a law changes no fit, so that each form would come out
    the same. None where that round took no law, or compared nothing."""
    before = found.stages[-1] if found.stages else None
    if before is None or before.taken is None or before.taken.law is None or not before.screening:
        return None
    ranked = [one for one in before.candidates if one is not before.taken]
    if not anything_but_spikes_matters(found.final, split):
        elsewhere = _convincing_elsewhere(found, split)
        ranked = [one for one in ranked if one.law is not None or one.cause in elsewhere]
    return _taken_of(Stage(before.screening, ranked, None), found, split)


def beside_its_law(stage: Stage, found: Found, split: Split) -> Stage:
    """A round that took a law, which changes no fit, with the best of its other causes taken, if one convinces; any
    other round as it is."""
    if stage.taken is None or stage.taken.law is None:
        return stage
    others = [one for one in stage.candidates if one.law is None]
    return _taken_of(Stage(stage.screening, others, None), found, split)


def _taken_of(stage: Stage, found: Found, split: Split) -> Stage:
    """The stage with the best of its candidates that convinces taken."""
    last, ranked, beside = found.final, stage.candidates, bool(found.findings)
    convincing = [one for one in ranked if convinces(one, last, split, beside)]
    chosen = convincing[0] if convincing else None
    if chosen is not None and any(
        one.merit > chosen.merit and is_too_little(one, last, split) and explains_the_same(one, chosen)
        for one in ranked
    ):
        chosen = None  # what is always there, and too little to be named, explains it better
    if chosen is not None and chosen.law is None and turns_the_joint(chosen.cause):
        foretold = _moved_as_foretold(chosen, split)
        ranked = [foretold if one is chosen else one for one in ranked]
        chosen = foretold
    return Stage(stage.screening, ranked, chosen)


def _telling_enough(stage: Stage, found: Found, split: Split) -> None:
    """Beside what was found, take the best that tells enough of its channels, if any does: what does not is a part of
    something without a name, which is told as left, and hides nothing that goes wrong elsewhere."""
    little: list[Candidate] = []
    now, beside = stage, bool(found.taken)
    while now.taken is not None and share_explained(now.taken, found.final, split, beside=beside) < EXPLAINED:
        little.append(now.taken)
        others = [one for one in now.candidates if one is not now.taken]
        now = _taken_of(Stage(stage.screening, others, None), found, split)
    stage.candidates, stage.taken = sorted([*now.candidates, *little], key=lambda one: -one.merit), now.taken


def _best_of_each(candidates: Sequence[Candidate]) -> list[Candidate]:
    """The best form of each cause, the best cause first."""
    best: dict[str, Candidate] = {}
    for one in sorted(candidates, key=lambda one: -one.merit):
        best.setdefault(one.cause, one)
    return list(best.values())


def _best_that_convinces(
    candidates: Sequence[Candidate], last: Fit, split: Split, beside: bool
) -> list[Candidate]:
    """The best form of each cause that convinces, or else the best, the best cause first: what one form of a mechanism
    takes for too little to be named, another may tell in full."""
    forms_of: dict[str, list[Candidate]] = {}
    for one in sorted(candidates, key=lambda one: -one.merit):
        forms_of.setdefault(one.cause, []).append(one)
    best = [
        next((one for one in of_cause if convinces(one, last, split, beside)), of_cause[0])
        for of_cause in forms_of.values()
    ]
    return by_one_measure(best, split)


def _drive_alone_looked_at(found: Found) -> bool:
    """Whether no round has looked at other causes than the drive's."""
    return all(turns_the_joint(one.cause.id) for stage in found.stages for one in stage.screening)


def _convincing_elsewhere(found: Found, split: Split) -> set[str]:
    """Causes that convinced in the round before, beside the one that was taken, and act elsewhere: what that
    one mends is none of theirs. They are judged again where nothing else is left that matters."""
    taken = found.stages[-1].taken
    if taken is None:
        return set()
    place = DECLARED[taken.cause].place
    return {one.cause for one in _convincing_before(found, split) if DECLARED[one.cause].place != place}


def _convincing_before(found: Found, split: Split) -> list[Candidate]:
    """The candidates that convinced in the round before, beside the one that it took, laws aside, the best first."""
    stage = found.stages[-1]
    if stage.taken is None:
        return []
    before = fit_before(found, stage.taken)
    return [one for one in stage.candidates if one.law is None and convinces(one, before, split, beside=True)]


def _joint_alone(last: Fit, split: Split) -> Fit:
    """A fit of the joint's channels only: what the drive did shows there, and is sought at a tenth of the cost."""
    measured, unseen = last.world.measured, np.full(last.world.measured.cycles, np.nan)
    frames = replace(
        measured.frames,
        **{name: getattr(measured.frames, name)[:0] for name in _OF_FRAMES},
    )
    alone = replace(measured, acceleration=unseen, deflection=unseen, frames=frames)
    world = World(alone, last.world.model, behind_encoder=last.world.behind_encoder)
    names = [name for name in world.baseline_names() if not name.startswith(("modes.", "jump."))]
    kept = [name for name in last.free if name.startswith("drive.") and name in world.space.place]
    return fit(make_data(world, split), carried_over(last, world), (*names, *dict.fromkeys(kept)))


def _of_the_whole(one: Candidate, last: Fit, split: Split) -> Candidate:
    """A form of the drive, fitted to the joint alone, fitted to all channels. The arm's modes and the sensors at the
    tip begin as they were: the joint alone says nothing of them."""
    told = [name for name in one.fit.free if name.startswith(_OF_JOINT) or name in one.free]
    values = {name: one.fit.value(name) for name in told if name in last.world.space.place}
    if one.begins is not None:
        values[one.begins] = one.fit.value(one.begins)
    world = last.world
    if one.fit.world.behind_encoder != world.behind_encoder:
        world = world.changed(behind_encoder=one.fit.world.behind_encoder)
    start = world.space.with_values(carried_over(last, world), values)
    names = free_names(last, world, one.free)
    fitted = fit(make_data(world, split), start, names, iterations=QUICK, colour=last.colour)
    return replace(one, fit=fitted)


def _moved_as_foretold(one: Candidate, split: Split) -> Candidate:
    """A finding of the drive with the arm moved by the simulated joint, as far as the finding foretells that: the
    measured one moves it by the encoder's noise and steps as well, which an arm's resonances enlarge."""
    last, world = one.fit, one.fit.world
    if world.joint_hz <= 0.0:
        return one
    foretold = world.changed(joint_hz=0.0).reported_position(last.vector)
    hz = departure_hz(world.measured.position, foretold, world.measured.cycle_s)
    if hz >= world.joint_hz:
        return one
    there = world.changed(joint_hz=hz)
    start, names = carried_over(last, there), free_names(last, there, one.free)
    anew = fit(make_data(there, split), start, names, colour=last.colour)
    better = float(score(anew, split).gain(score(last, split)).sum()) > 0.0
    return replace(one, fit=anew) if better else one


def joint_departs(last: Fit) -> bool:
    """Whether the joint's own sensors show a departure of the drive."""
    world = last.world
    if world.joint_hz <= 0.0:
        return False
    for name in JOINT_CHANNELS:
        if name in last.residuals:
            noise = white_noise(last, name)
            power = float(np.nanmean(last.residuals[name] ** 2))
            if power - noise**2 > (MATTERS_OF_NOISE * noise) ** 2:
                return True
    return False
