"""Which causes are in the data: every form of every cause refitted, and judged by how well it foretells the recording.

The search (rounds.py) begins from a baseline. Which one that is, is a part of the question: that of the first part for
what sets in on the way, that of the modes as stated for what bends the fitted ones out of all measure, one without
impacts that a wrong model of the moves has had made up, one of images that are dated anew beside what was found in
them.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from stillarm.diagnosis.data.channels import BEND_CHANNELS, JOINT_CHANNELS
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.decision.decide import share_explained
from stillarm.diagnosis.decision.rival_causes import stage_of
from stillarm.diagnosis.decision.rounds import (
    beside_its_law,
    explained,
    joint_departs,
    one_round,
    with_hint,
)
from stillarm.diagnosis.events.impacts import impacts_while_moving, without_impacts_while_moving
from stillarm.diagnosis.fitting.evidence import PRICE_NATS, Score, score
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import Fit, carried_over, make_data
from stillarm.diagnosis.fitting.gains import free_names
from stillarm.diagnosis.fitting.rest import anything_but_spikes_matters, rest_of
from stillarm.diagnosis.physics.computing import OutOfTime, limited_to
from stillarm.diagnosis.search.candidates import (
    EXPLAINED,
    Candidate,
    Found,
    Hint,
    Stage,
    beside_another,
    turns_the_joint,
)
from stillarm.diagnosis.search.convincing import convinces
from stillarm.diagnosis.search.early_baseline import early_baseline
from stillarm.diagnosis.search.stated_baseline import stated_baseline
from stillarm.diagnosis.sensors.image_dating import dated_anew
from stillarm.diagnosis.sensors.laws import LawFound

_A_FEW = 3  # impacts, which may fall into one part of the recording by chance
_ANOTHER_SHARE = 0.6  # of the time: a round beside the usual baseline may have to follow
_Beginning = tuple[Found, list[Stage]]
"""Where a search begins, and the rounds that are made already."""


def explain(
    baseline: Fit,
    split: Split,
    tick: Callable[[float, str], None] = lambda done, what: None,
    only: Sequence[str] | None = None,
    known: Sequence[LawFound] = (),
) -> Found:
    """Take causes one after another while one convinces. known: laws that were found while the data were read."""
    found = _searched(baseline, split, tick, only, known)
    if not found.findings or found.final is found.baseline or _images_told(found.final, split):
        return found
    try:
        anew = dated_anew(found.baseline, found.final, split)
    except OutOfTime:
        return found
    return found if anew is None else _searched(anew, split, tick, only, known)


def _images_told(final: Fit, split: Split) -> bool:
    """Whether nothing that matters is left in the images."""
    return "displacement" not in final.residuals or rest_of(final, "displacement", split).immaterial


def _searched(
    baseline: Fit,
    split: Split,
    tick: Callable[[float, str], None],
    only: Sequence[str] | None,
    known: Sequence[LawFound],
    hint: Hint | None = None,
) -> Found:
    """The search from a baseline, or from the likelier one that its first round comes upon. hint: as in Found."""
    begun = first = None
    usual = Found(baseline, baseline)
    # The drive is sought first then, and alone: by the joint as it was measured, which moves the arm, whatever the
    # baseline says of that and of impacts.
    departs = joint_departs(baseline)
    if hint is None:
        if not known and (departs or not impacts_while_moving(baseline)):
            first = _first_round(usual, split, tick, only)
        if not departs and (first is None or not _leaves_nothing(first, usual, split)):
            begun, hint = _from_another_baseline(baseline, split, tick, only)
    if begun is None and not departs:
        begun, hint = _without_doubtful_impacts(baseline, split, only, hint)
    usual.hint = hint
    if begun is not None:
        told = explained(begun[0], split, tick, only, known, begun[1])
    else:
        told = explained(usual, split, tick, only, known, first=with_hint(first, usual, split))
    if departs and told.likelier is None:
        told = _beside_the_drive(told, split, tick, only, known)
    if told.likelier is None:
        return told
    return _searched(told.likelier, split, tick, only, known, told.hint)


def _first_round(
    usual: Found, split: Split, tick: Callable[[float, str], None], only: Sequence[str] | None
) -> Stage | None:
    """The first round beside the usual baseline: where that explains all that matters, no other one is asked for. None
    where nothing matters, or the time does not suffice."""
    try:
        if not anything_but_spikes_matters(usual.baseline, split):
            return None
        tick(0.0, "causes, round 1")
        return one_round(usual, split, only, upstream=joint_departs(usual.baseline))
    except OutOfTime:
        return None


def _leaves_nothing(stage: Stage, usual: Found, split: Split) -> bool:
    """Whether what a round took, its law aside, leaves nothing that matters; not where the time does not suffice to
    tell."""
    try:
        one = beside_its_law(stage, usual, split).taken
    except OutOfTime:
        return False
    return one is not None and not anything_but_spikes_matters(one.fit, split)


def _from_another_baseline(
    baseline: Fit, split: Split, tick: Callable[[float, str], None], only: Sequence[str] | None
) -> tuple[_Beginning | None, Hint | None]:
    """What explains the recording beside the modes as stated, where the usual baseline has left them, or beside the
    baseline of its first part, where that is much the better one there, and there what sets in on the way. It is to
    explain most of what the usual baseline leaves. None where it does not; and then what acts throughout, which is to
    be tried beside the usual baseline."""
    try:
        if not anything_but_spikes_matters(baseline, split):
            return None, None
        stated = stated_baseline(baseline, split)
        other = stated or early_baseline(baseline, split)
        stage = _round_beside(other, split, tick, only)
    except OutOfTime:
        return None, None
    if stage is None or other is None:
        return None, None
    hint = Hint(other, stage)
    begun = None
    if _sets_in(hint.taken) or other is stated:
        moved = _beside(stage, other, baseline, split)
        assert moved.taken is not None
        most = share_explained(moved.taken, baseline, split) >= EXPLAINED
        if most and convinces(moved.taken, baseline, split, False):
            begun = Found(baseline, baseline), [moved]
    return begun, None if begun or _sets_in(hint.taken) else hint


def _round_beside(
    other: Fit | None, split: Split, tick: Callable[[float, str], None], only: Sequence[str] | None
) -> Stage | None:
    """A round beside another baseline than the usual one, laws aside; None where there is none, or nothing is
    taken."""
    if other is None:
        return None
    tick(0.0, "causes, beside another baseline")
    found = Found(other, other)
    with limited_to(_ANOTHER_SHARE):
        stage = one_round(found, split, only, upstream=joint_departs(other))
        stage = beside_its_law(stage, found, split)
    return stage if stage.taken is not None else None


def _sets_in(one: Candidate) -> bool:
    """Whether a finding acts from an instant on: one that does not is found beside the usual baseline as well."""
    return one.law is None and (one.begins is not None or "onset_s" in one.values)


def _beside(stage: Stage, first: Fit, baseline: Fit, split: Split) -> Stage:
    """A round's candidates with their merits over another baseline than the one that they were found on."""
    assert stage.taken is not None
    ranked = beside_another(stage.candidates, score(first, split), score(baseline, split))
    return Stage(stage.screening, ranked, ranked[stage.candidates.index(stage.taken)])


def _without_doubtful_impacts(
    baseline: Fit, split: Split, only: Sequence[str] | None, hint: Hint | None
) -> tuple[_Beginning | None, Hint | None]:
    """What explains the recording without the impacts that were found while the joint moved, where that is likelier: a
    model that is wrong about moves is put right by an impact at each. None where it is not; and then what was found
    without them, which is to be tried beside them. hint: as in Found."""
    doubtful = impacts_while_moving(baseline)
    if not doubtful or _moves_are_told(baseline, split, doubtful):
        return None, hint
    try:
        plain = _refitted_without_them(baseline, split)
        found = Found(plain, plain, hint=hint)
        before, spared = score(baseline, split), _price_of(doubtful, baseline)
        if float(score(plain, split).gain(before).sum()) > -spared:
            return (found, []), hint
        stage, likelier = _round_without_them(found, before, spared, split, only)
    except OutOfTime:
        return None, hint
    if stage.taken is None:
        return None, hint
    return ((found, [stage]), hint) if likelier else (None, Hint(plain, stage))


def _round_without_them(
    found: Found, before: Score, spared: float, split: Split, only: Sequence[str] | None
) -> tuple[Stage, bool]:
    """A round without the impacts that were found while the joint moved, its law aside, and whether the recording is
    likelier so than with them. before: the score with them; spared: their price. Raises OutOfTime."""
    with limited_to(_ANOTHER_SHARE):
        stage = beside_its_law(one_round(found, split, only, upstream=False), found, split)
    if stage.taken is None:
        return stage, False
    lead = float(score(stage.taken.fit, split).gain(before).sum())
    return stage, lead >= PRICE_NATS * len(stage.taken.free) - spared


def _refitted_without_them(last: Fit, split: Split) -> Fit:
    """The same fit without the impacts that were found while the joint moved."""
    fewer = without_impacts_while_moving(last)
    names = free_names(last, fewer, ())
    return fit(make_data(fewer, split), carried_over(last, fewer), names, colour=last.colour)


def _price_of(impacts: Sequence[int], last: Fit) -> float:
    """Nats that the numbers cost which a fit spends on so many impacts."""
    return PRICE_NATS * len(impacts) * (2 * last.world.modes + 2)


def _beside_the_drive(
    told: Found,
    split: Split,
    tick: Callable[[float, str], None],
    only: Sequence[str] | None,
    known: Sequence[LawFound],
) -> Found:
    """What was found of the drive, with what explains the arm beside that without the impacts that were found while the
    joint moved, where that is likelier. The drive is sought beside all impacts; these may have made up for what else is
    wrong about moves, so that nothing is left. As it was where it is not, or where more was found."""
    last, taken = told.final, told.taken
    if not taken or not all(turns_the_joint(one.cause) for one in taken):
        return told
    doubtful = impacts_while_moving(last)
    if not doubtful or _moves_are_told(last, split, doubtful):
        return told
    try:
        plain = _refitted_without_them(last, split)
        before, spared = score(last, split), _price_of(doubtful, last)
        stage, likelier = _round_without_them(replace(told, final=plain), before, spared, split, only)
    except OutOfTime:
        return told
    if not likelier:
        return told
    begun = [stage_of(told, one) for one in taken]
    begun[-1] = replace(begun[-1], taken=replace(taken[-1], fit=plain))
    return explained(Found(told.baseline, told.baseline), split, tick, only, known, [*begun, stage])


def _moves_are_told(baseline: Fit, split: Split, doubtful: Sequence[int]) -> bool:
    """Whether the joint moved as told, and what shows all bends shows nothing amiss with an impact in the fewest of the
    moves: what is wrong is then wrong in another sensor, and no model of the moves."""
    if _most_moves_have_one(baseline, doubtful):
        return False
    told = {name: rest_of(baseline, name, split).immaterial for name in baseline.residuals}
    joint = [told[name] for name in JOINT_CHANNELS if name in told]
    return bool(joint) and all(joint) and any(told[name] for name in BEND_CHANNELS if name in told)


def _most_moves_have_one(baseline: Fit, impacts: Sequence[int]) -> bool:
    """Whether so many impacts suffice for most of the moves, of all or, where they are more than a few, of those from
    the first of them to the last: what sets in on the way bends the moves since."""
    turning = baseline.world.measured.told_to_move
    if len(impacts) > _A_FEW:
        turning = turning[: impacts[-1] + 1]
        before = np.flatnonzero(~turning[: impacts[0]])  # from the rest before the first of them
        turning = turning[before[-1] if len(before) else 0 :]
    return 2 * len(impacts) > int(np.count_nonzero(np.diff(turning.astype(int)) > 0))
