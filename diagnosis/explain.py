"""Which causes are in the data: every form of every cause refitted, and judged by how well it foretells the recording.

One round: the forms that a score test finds worth a look are refitted, the best of them to the end, some with an onset;
each is worth the log score that it gains over all blocks (stillarm.diagnosis.evidence), less what its numbers cost. The
best is taken, and the next round looks at what it leaves.
"""

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.common.causes import CAUSES as DECLARED
from stillarm.diagnosis.budget import OutOfTime
from stillarm.diagnosis.candidate import Candidate, Found, Stage
from stillarm.diagnosis.channels import JOINT_CHANNELS
from stillarm.diagnosis.evidence import Score, score
from stillarm.diagnosis.fit import Data, Fit, Split, fit, least_level, make_data, slopes_of
from stillarm.diagnosis.forms import Form, forms, from_an_onset
from stillarm.diagnosis.impacts import carried_over
from stillarm.diagnosis.laws import LawFound, backward_steps, laws
from stillarm.diagnosis.screen import Screening, screen
from stillarm.diagnosis.side_by_side import side_by_side
from stillarm.diagnosis.world import World

Array = NDArray[np.float64]
Slopes = Mapping[str, Mapping[str, Array]]

MOST_CAUSES = 3
PRICE_NATS = 3.0
"""What each number that a form fits costs: half the logarithm of the thousand or so independent things that a block's
bands tell (Schwarz 1978)."""
CONVINCING_NATS = 12.0
"""Least merit of a finding: odds of 20 to 1 (3 nats) against each of some hundred forms, onsets and sizes tried
(log 100 = 4.6), and as much again for noise that is not quite what the score takes it for."""
LEAST_OF_NOISE = 0.15
"""Least effect with a name, of a channel's noise: what the model's discrepancy may be anyhow."""
MATTERS_OF_NOISE = 0.5
"""A rest that matters is over this part of a channel's noise (contract.md)."""
_WHOLE = 3  # forms of the drive that are fitted to all channels
_OF_FRAMES = ("counter", "received_s", "started_s", "displacement_px", "captured_s")
_SCREENED_NATS = 8.0
_MOST_TRIALS, _SETTLED_NATS = 40, 0.02  # of a search along a quantity; what counts as a gain there
_STARTS, _MOST_STARTS = 2, 8  # by their scores; with those that the data ask for
_QUICK, _FULL = 4, 12  # steps of a fit
_POLISHED = 3  # causes
_ONSETS, _WITH_ONSET = 6, 4  # tried; forms that an onset is tried for
_ONSET_LEAST_S = 0.01
_DEPARTS = 1.5  # times the level that a simulation reaches
_WORTH_A_FIT = 0.03  # of the best form's gain: of what explains less, a later round says more


@dataclass(frozen=True)
class _Begun:
    """A form with its world and where its fit begins."""

    form: Form
    world: World
    start: Array
    asked: bool = False


def explain(
    baseline: Fit,
    split: Split,
    tick: Callable[[float, str], None] = lambda done, what: None,
    only: Sequence[str] | None = None,
    known: Sequence[LawFound] = (),
) -> Found:
    """Take causes one after another while one convinces. known: laws that were found while the data were read."""
    found = Found(baseline, baseline)
    other = _without_doubtful_impacts(baseline, split, tick, only, known)
    if other is not None:
        return other
    return _explained(found, split, tick, only, known)


def _without_doubtful_impacts(
    baseline: Fit,
    split: Split,
    tick: Callable[[float, str], None],
    only: Sequence[str] | None,
    known: Sequence[LawFound],
) -> Found | None:
    """What explains the recording without the impacts that were found while the joint moved, where that is likelier: a
    model that is wrong about moves is put right by an impact at each. None where it is not."""
    doubtful = _while_moving(baseline)
    if not doubtful:
        return None
    world = baseline.world
    kept = tuple(cycle for cycle in world.impacts if cycle not in doubtful)
    fewer = world.changed(impacts=kept, strokes=world.strokes)
    try:
        start = carried_over(baseline, fewer)
        names = free_names(baseline, fewer, ())
        plain = fit(make_data(fewer, split), start, names, iterations=_FULL, colour=baseline.colour)
        found = Found(plain, plain)
        stage = _round(found, split, only, upstream=_joint_departs(plain))
    except OutOfTime:
        return None
    if stage.taken is None or stage.taken.law is not None:
        return None
    lead = score(stage.taken.fit, split).gain(score(baseline, split))
    price = PRICE_NATS * (len(stage.taken.free) - len(doubtful) * (2 * world.modes + 2))
    if float(lead.sum()) < price:
        return None
    return _explained(found, split, tick, only, known, [stage])


def _while_moving(baseline: Fit) -> list[int]:
    """The impacts within a swing of which the joint was on the move."""
    world = baseline.world
    command = np.nan_to_num(world.measured.command)
    reach = round(1.0 / (baseline.value("modes.0.frequency_hz") * world.measured.cycle_s))
    still = 0.01 * float(np.max(np.abs(command), initial=0.0))
    return [
        cycle
        for cycle in world.impacts
        if still > 0.0 and np.any(np.abs(command[max(cycle - reach, 0) : cycle + reach]) > still)
    ]


def _explained(
    found: Found,
    split: Split,
    tick: Callable[[float, str], None],
    only: Sequence[str] | None,
    known: Sequence[LawFound],
    begun: Sequence[Stage] = (),
) -> Found:
    """The findings one after another. begun: rounds that are made already."""
    baseline = found.baseline
    data = make_data(baseline.world, split)
    for law in (*known, *backward_steps(data)):
        one = of_law(baseline, law)
        found.findings.append(one)
        found.stages.append(Stage(Screening([], 0.0), [one], one))
    for stage in begun:
        assert stage.taken is not None
        found.stages.append(stage)
        found.findings.append(stage.taken)
        found.final = stage.taken.fit
    for turn in range(len(begun), MOST_CAUSES):
        tick(turn / MOST_CAUSES, f"causes, round {turn + 1}")
        upstream = turn == 0 and _joint_departs(found.final)
        stage = _round(found, split, only, upstream)
        found.stages.append(stage)
        if stage.taken is None and upstream:
            stage = _round(found, split, only, upstream=False)
            found.stages.append(stage)
        if stage.taken is None:
            break
        found.findings.append(stage.taken)
        if stage.taken.law is None:
            found.final = stage.taken.fit
    return found


def _round(found: Found, split: Split, only: Sequence[str] | None, upstream: bool) -> Stage:
    """One round. upstream: of the drive alone, where the joint departs: the arm is judged by the joint as measured, so
    that what the drive did is no matter of the arm's."""
    last, taken = found.final, {one.cause for one in found.findings}
    allowed = [one for one in forms(last.world) if one.id not in taken and (only is None or one.id in only)]
    if upstream:
        drive = [one for one in allowed if _turns_the_joint(one)]
        screening, candidates = _compared(_joint_alone(last, split), drive, split, found)
        candidates = [_of_the_whole(one, last, split) for one in candidates[:_WHOLE]]
    else:
        screening, candidates = _compared(last, _where_it_departs(allowed, last), split, found)
        try:
            known = laws(make_data(last.world, split), last)
            candidates += [of_law(last, law) for law in known if law.cause not in taken]
        except OutOfTime:
            found.left_out.append("laws of noise and timing")
    candidates.sort(key=lambda one: -one.merit)
    best_of: dict[str, Candidate] = {}
    for one in candidates:
        best_of.setdefault(one.cause, one)
    ranked = list(best_of.values())
    beside = bool(found.findings)
    convincing = [one for one in ranked if convinces(one, last, beside)]
    return Stage(screening, ranked, convincing[0] if convincing else None)


def _compared(
    last: Fit, tried: Sequence[Form], split: Split, found: Found
) -> tuple[Screening, list[Candidate]]:
    """Each form refitted on top of a fit, and what it is worth; the best first."""
    candidates: list[Candidate] = []
    screening = Screening([], _SCREENED_NATS)
    try:
        before, data = score(last, split), make_data(last.world, split)
        begun, screening = _begun(data, last, tried)
        slopes = slopes_of(last)
        quick = _each(lambda one: (one, _refitted(one, last, split, slopes)), begun, found)
        best = _best_of_each(quick, last)
        ended = _each(lambda pair: (pair[0], _to_the_end(pair[0], pair[1], last, split, slopes)), best, found)
        candidates += [_candidate(one, fitted, last, before, split) for one, fitted in ended]
        later = _each(
            lambda one: _with_onset(one, last, split, slopes), _worth_an_onset(candidates, ended), found
        )
        candidates += [_candidate(one, fitted, last, before, split) for one, fitted in later]
        best_forms = _leading([*ended, *later], candidates)
        polished = _each(lambda pair: (pair[0], _polished(pair[0], pair[1], last, split)), best_forms, found)
        candidates += [_candidate(one, fitted, last, before, split) for one, fitted in polished]
    except OutOfTime:
        found.left_out.append("some forms of causes")
    return screening, sorted(candidates, key=lambda one: -one.merit)


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
    """A form of the drive, fitted to the joint alone, fitted to all channels."""
    values = {name: one.fit.value(name) for name in one.fit.free if name in last.world.space.place}
    if one.begins is not None:
        values[one.begins] = one.fit.value(one.begins)
    world = last.world
    if one.fit.world.behind_encoder != world.behind_encoder:
        world = world.changed(behind_encoder=one.fit.world.behind_encoder)
    start = world.space.with_values(carried_over(last, world), values)
    names = free_names(last, world, one.free)
    fitted = fit(make_data(world, split), start, names, iterations=_QUICK, colour=last.colour)
    return replace(one, fit=fitted)


def convinces(one: Candidate, last: Fit, beside: bool) -> bool:
    """Whether a candidate is more than chance and more than a model's usual discrepancy, and within its bounds.
    beside: a finding there is already: what does not matter beside it is told as left."""
    if one.merit < CONVINCING_NATS or not _within_bounds(one):
        return False
    if one.law is not None:
        return True
    return size_in_noise(last, one.fit) > (MATTERS_OF_NOISE if beside else LEAST_OF_NOISE)


def size_in_noise(before: Fit, after: Fit) -> float:
    """How much less is left in the channel that a cause mends most, over that channel's noise."""
    return max(_mended(before, after, name) for name in before.residuals)


def _mended(before: Fit, after: Fit, name: str) -> float:
    power = float(np.nanmean(before.residuals[name] ** 2) - np.nanmean(after.residuals[name] ** 2))
    return sqrt(max(power, 0.0)) / max(
        min(before.sigma[name], after.sigma[name]), least_level(before.world, name)
    )


def _each(work: Callable[..., object], items: Sequence[object], found: Found) -> list:  # type: ignore[type-arg]
    """The work on each item; what the time did not suffice for is left out, and told."""

    def tried(item: object) -> object:
        try:
            return work(item)
        except OutOfTime:
            return None

    done = list(side_by_side(tried, items))
    if any(one is None for one in done) and "some forms of causes" not in found.left_out:
        found.left_out.append("some forms of causes")
    return [one for one in done if one is not None and one[1] is not None]  # type: ignore[index]


def _joint_departs(last: Fit) -> bool:
    """Whether the joint's own sensors show a departure of the drive."""
    world = last.world
    joint = last.channel("joint_position")
    if world.joint_hz <= 0.0 or joint is None:
        return False
    return float(np.sqrt(np.nanmean(joint.residual**2))) > _DEPARTS * least_level(world, "joint_position")


def _where_it_departs(tried: Sequence[Form], last: Fit) -> list[Form]:
    """The forms that may be at work: not the drive's, where the joint's own sensors show no departure."""
    if not any(name in last.world.channels for name in JOINT_CHANNELS) or _joint_departs(last):
        return list(tried)
    return [one for one in tried if not _turns_the_joint(one) or one.id == "gear_backlash"]


def _turns_the_joint(one: Form) -> bool:
    """Whether it shows in how the joint moves: all of the drive's but a rotor's imbalance, which shakes the arm."""
    return DECLARED[one.id].place == "drive" and DECLARED[one.id].acts != "force"


def _begun(data: Data, last: Fit, tried: Sequence[Form]) -> tuple[list[_Begun], Screening]:
    """Where fits begin: the best trials of each form by a score test, and those that the data ask for."""
    by_cause = {id(one.cause): one for one in tried}
    screening = screen(
        data, last, [one.cause for one in tried if one.added is None], threshold_nats=_SCREENED_NATS
    )
    begun: list[_Begun] = []
    count: dict[int, int] = defaultdict(int)
    for one in screening.scored:
        if not one.trial.asked and (one.nats < _SCREENED_NATS or count[id(one.cause)] >= _STARTS):
            continue
        count[id(one.cause)] += 1
        if count[id(one.cause)] > _MOST_STARTS:
            continue
        begun.append(_Begun(by_cause[id(one.cause)], one.world, one.start, one.trial.asked))
    for form in tried:
        if form.added is not None:
            world = last.world.changed(added=(*last.world.added, *form.added(last)))
            begun.append(_Begun(form, world, carried_over(last, world)))
    return begun, screening


def free_names(last: Fit, world: World, own: Sequence[str]) -> tuple[str, ...]:
    """What a fit of a further cause frees: the baseline, what earlier findings freed, and its own."""
    kept = [name for name in last.free if name in world.space.place]
    return tuple(dict.fromkeys((*world.baseline_names(), *kept, *own)))


def _refitted(one: _Begun, last: Fit, split: Split, slopes: Slopes) -> Fit | None:
    names = free_names(last, one.world, one.form.cause.free(one.world))
    data = make_data(one.world, split)
    fitted = fit(data, one.start, names, iterations=_QUICK, colour=last.colour, known=slopes)
    return fitted if one.form.cause.possible(fitted) else None


def _gain(fitted: Fit, last: Fit) -> float:
    gained = fitted.held_out_score - last.held_out_score
    return fitted.train_log_likelihood - last.train_log_likelihood + float(np.sum(gained))


def _best_of_each(quick: list[tuple[_Begun, Fit]], last: Fit) -> list[tuple[_Begun, Fit]]:
    """The best start of each form, without those that explain next to nothing of what the best of their place does."""
    best: dict[tuple[str, str], tuple[_Begun, Fit]] = {}
    for one, fitted in quick:
        key = (one.form.id, one.form.name)
        if key not in best or _gain(fitted, last) > _gain(best[key][1], last):
            best[key] = (one, fitted)
    top = max((_gain(fitted, last) for _, fitted in best.values()), default=0.0)
    kept = [
        pair
        for pair in best.values()
        if _gain(pair[1], last) > _WORTH_A_FIT * top or pair[0].form.added or pair[0].asked
    ]
    return sorted(kept, key=lambda pair: -_gain(pair[1], last))


def _to_the_end(one: _Begun, fitted: Fit, last: Fit, split: Split, slopes: Slopes) -> Fit | None:
    """All quantities at their best: thresholds and onsets by a search along them, then the rest."""
    data = make_data(one.world, split)
    if one.form.cause.settle:
        fitted = _settled(one, fitted, last, data, slopes)
    ended = fit(data, fitted.vector, fitted.free, iterations=_FULL, colour=last.colour, known=slopes)
    return ended if one.form.cause.possible(ended) else None


def _polished(one: _Begun, fitted: Fit, last: Fit, split: Split) -> Fit:
    """The same with all derivatives worked out where it is."""
    return fit(make_data(one.world, split), fitted.vector, fitted.free, iterations=_FULL, colour=last.colour)


def _leading(fits: list[tuple[_Begun, Fit]], candidates: Sequence[Candidate]) -> list[tuple[_Begun, Fit]]:
    """The best form of each of the few causes that may be taken."""
    merit = {id(one.fit): one.merit for one in candidates}
    found: dict[str, tuple[_Begun, Fit]] = {}
    for one, fitted in sorted(fits, key=lambda pair: -merit.get(id(pair[1]), 0.0)):
        if merit.get(id(fitted), 0.0) > PRICE_NATS and len(found) < _POLISHED:
            found.setdefault(one.form.id, (one, fitted))
    return list(found.values())


def _settled(one: _Begun, best: Fit, last: Fit, data: Data, slopes: Slopes) -> Fit:
    """Quantities without a smooth derivative, searched along with halving steps, all else following."""
    for name, first in one.form.cause.settle.items():
        onset = "onset" in name
        step = first * (1.0 if onset else max(abs(best.value(name)), 1e-3) * 10.0)
        least = 4.0 * best.world.measured.cycle_s if onset else 0.02 * step
        names = [each for each in best.free if each != name]
        trials = 0
        while step > least and trials < _MOST_TRIALS:
            moved = False
            for sign in (1.0, -1.0):
                trials += 1
                start = best.world.space.with_values(best.vector, {name: best.value(name) + sign * step})
                trial = fit(data, start, names, iterations=1, colour=last.colour, known=slopes)
                if _gain(trial, best) > _SETTLED_NATS:
                    best, moved = replace(trial, free=best.free), True
                    break
            if not moved:
                step *= 0.4
    return best


def _worth_an_onset(
    candidates: Sequence[Candidate], ended: list[tuple[_Begun, Fit]]
) -> list[tuple[_Begun, Fit]]:
    """The forms that gain most and may have begun within the recording."""
    merit = {(one.cause, one.form): one.merit for one in candidates}
    found = []
    for one, fitted in sorted(ended, key=lambda pair: -merit.get((pair[0].form.id, pair[0].form.name), 0.0)):
        later = from_an_onset(one.form)
        if later is not None:
            found.append((replace(one, form=later), fitted))
    # what acts in half of the recording alone may do worse than nothing throughout
    by_fit = sorted(found, key=lambda pair: -pair[1].train_log_likelihood)[: _WITH_ONSET // 2]
    by_merit = [pair for pair in found if pair not in by_fit][: _WITH_ONSET - len(by_fit)]
    return [*by_fit, *by_merit]


def _with_onset(pair: tuple[_Begun, Fit], last: Fit, split: Split, slopes: Slopes) -> tuple[_Begun, Fit]:
    """The form fitted with the instant from which it acts: over a grid, then along it by halving steps."""
    one, whole = pair
    data, begins = make_data(one.world, split), one.form.begins
    assert begins is not None
    duration = one.world.measured.duration_s

    def at(onset: float, near: Fit, steps: int = 1) -> Fit:
        start = one.world.space.with_values(near.vector, {begins: onset})
        return fit(data, start, near.free, iterations=steps, colour=last.colour, known=slopes)

    best = max(
        (at(x, whole) for x in np.linspace(0.1, 0.85, _ONSETS) * duration), key=lambda f: _gain(f, last)
    )
    step = 0.5 * 0.75 * duration / (_ONSETS - 1)
    while step > _ONSET_LEAST_S:
        tried = max(
            (at(best.value(begins) + sign * step, best) for sign in (1, -1)), key=lambda f: _gain(f, last)
        )
        if _gain(tried, last) > _gain(best, last) + 0.02:
            best = tried
        else:
            step *= 0.5
    return one, fit(data, best.vector, best.free, iterations=_QUICK, colour=last.colour, known=slopes)


def _candidate(one: _Begun, fitted: Fit, last: Fit, before: Score, split: Split) -> Candidate:
    after = score(fitted, split)
    nats, held = after.gain(before), after.gain(before, whole=False)[split.held]
    own = one.form.cause.free(fitted.world)
    values = one.form.cause.parameters_of(fitted)
    merit = (
        float(nats.sum())
        - PRICE_NATS * (len(own) + (2 if one.form.begins else 0))
        - one.form.cause.prior_penalty(fitted)
    )
    if one.form.added is not None:  # of many amounts: what it was fitted to says little of what it foretells
        merit = min(merit, 3.0 * float(held.sum()))
    white = fitted.held_out_score - last.held_out_score
    return Candidate(
        one.form.id, fitted, fitted.train_log_likelihood - last.train_log_likelihood, float(held.sum()),
        float(held.std(ddof=1) * sqrt(len(held))), white, values, None, own,
        train_blocks=fitted.train_blocks - last.train_blocks, form=one.form.name,
        begins=one.form.begins, merit=merit, nats=nats,
        begins_s=fitted.value(one.form.begins) if one.form.begins else None,
        parameters_of=one.form.cause.parameters_of,
    )  # fmt: skip


def of_law(last: Fit, law: LawFound) -> Candidate:
    """A law of noise or timing as a candidate: each block is judged by what the others say already."""
    gains = law.held_out_score
    spread = float(np.std(gains, ddof=1) * sqrt(len(gains)))
    return Candidate(
        law.cause, last, law.train_log_likelihood, float(gains.sum()), spread, gains, law.values, law,
        tuple(law.values), law.note, merit=float(gains.sum()) - PRICE_NATS * len(law.values), nats=gains,
    )  # fmt: skip


def _within_bounds(one: Candidate) -> bool:
    known = {parameter.name: parameter for parameter in DECLARED[one.cause].parameters}
    for name, (value, _) in one.values.items():
        parameter = known.get(name)
        if parameter is not None and parameter.kind in ("number", "whole"):
            slack = 1e-9 * max(abs(parameter.lowest), abs(parameter.highest))
            if not parameter.lowest - slack <= value <= parameter.highest + slack:
                return False
    return True
