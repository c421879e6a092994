"""Measured data in, verdict out, within a budget of time. docs/diagnosis.md tells how it decides."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from stillarm.common.files.model import Model
from stillarm.common.user_error import UserError
from stillarm.diagnosis.data.channels import without_dead_sensors
from stillarm.diagnosis.data.measured import Measured, first_part
from stillarm.diagnosis.data.split import Split, interleaved, stated
from stillarm.diagnosis.decision.budget import Budget, affordable
from stillarm.diagnosis.decision.decide import Judged, judge
from stillarm.diagnosis.decision.explain import explain
from stillarm.diagnosis.events.impact_onsets import with_impacts_at_onsets
from stillarm.diagnosis.events.pulls import without_pushes
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import Fit, make_data
from stillarm.diagnosis.physics.computing import OutOfTime
from stillarm.diagnosis.physics.memory import give_back
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.search.baseline import (
    HURRIED_STEPS,
    fitted_baseline,
    moved_as_measured,
    with_lost_modes,
)
from stillarm.diagnosis.search.candidates import Found
from stillarm.diagnosis.search.comparison import LEFT_OUT
from stillarm.diagnosis.sensors.clocks import without_old_images, without_set_stamps, without_steps
from stillarm.diagnosis.sensors.image_dating import dated, recounted
from stillarm.diagnosis.sensors.laws import LawFound

Tick = Callable[[float, str], None]

_BASELINE_SHARE, _CLOCKS_SHARE = 0.45, 0.6  # of the time for all stages
_JUDGED_SHARE = 1.1  # of what the stages may take: the verdict's share of the budget holds as much


@dataclass(frozen=True)
class Outcome:
    """What was found and judged. left_out: what the time did not suffice for; channels_left_out: why, by channel."""

    found: Found
    judged: Judged
    split: Split
    left_out: list[str]
    channels_left_out: dict[str, str]


def run(
    measured: Measured, model: Model, hold_out: Sequence[tuple[float, float]], tick: Tick, budget: Budget
) -> Outcome:
    """Look for causes in a recording, and judge what was found. Raises UserError where it shows nothing.

    model: its effects complete. hold_out: spans, s, in the recording's own time; none: as `interleaved` has them.
    """
    measured, dead = without_dead_sensors(measured)
    world = World(measured, model)
    unused = dead | world.channels_left_out
    if not set(world.channels) - {"arrival"}:
        raise UserError(f"{measured.name}: {_nothing_shown(measured.pair, unused)}")
    left_out: list[str] = []
    affordable_s = affordable(world, budget)
    if affordable_s < measured.duration_s:
        left_out.append(f"time after {measured.origin_s + affordable_s:g} s")
        measured = first_part(measured, affordable_s)
        world = World(measured, model)
    split = (
        stated(hold_out, measured.origin_s, measured.duration_s)
        if hold_out
        else interleaved(measured.duration_s)
    )
    tick(0.05, "baseline")
    baseline, known = _baseline_within(budget, world, split, left_out)
    try:
        with budget.limit():
            found = explain(baseline, split, lambda done, what: tick(0.1 + 0.75 * done, what), known=known)
    except OutOfTime:
        found = Found(baseline, baseline, left_out=[LEFT_OUT])
    tick(0.92, "what is left")
    give_back()
    with budget.limit(_JUDGED_SHARE):
        judged = judge(found, split)
    left_out += [*dict.fromkeys(found.left_out), *judged.left_out]
    if judged.verdict == "none":
        found.findings, found.final = [], found.baseline
    return Outcome(found, judged, split, left_out, unused)


def _nothing_shown(pair: bool, unused: dict[str, str]) -> str:
    """Why no channel can be diagnosed, and what to do."""
    why = "; ".join(f"{name}: {reason}" for name, reason in unused.items())
    if pair:
        return f"the output cannot be diagnosed ({why or 'no values'}); map another column to output"
    return (
        "no measured channel (acceleration, joint motion, deflection, displacement) has enough values that "
        f"vary{f' ({why})' if why else ''}; see the columns of fast.csv and frames.csv"
    )


def _baseline_within(
    budget: Budget, world: World, split: Split, left_out: list[str]
) -> tuple[Fit, tuple[LawFound, ...]]:
    """The baseline as far as the time goes, and the laws found on the way; adds to left_out what it did not go to."""
    since_s = budget.used_s
    reached: list[Fit] = []
    try:
        with budget.limit(_BASELINE_SHARE, since_s):
            world = moved_as_measured(world, split)
            baseline = fitted_baseline(world, split, reached.append)
            reached.append(baseline)
            baseline = with_impacts_at_onsets(baseline, split)
            reached.append(baseline)
            baseline = without_pushes(baseline, split)
    except OutOfTime:
        left_out.append("some impacts" if reached else "impacts")
        return reached[-1] if reached else _hurried(budget, since_s, world, split, left_out), ()
    known: list[LawFound] = []
    try:
        with budget.limit(_CLOCKS_SHARE, since_s):
            baseline = recounted(dated(baseline, split), split)
            baseline = with_lost_modes(baseline, split)
            for mended in (without_steps, without_set_stamps, without_old_images):
                baseline, found = mended(baseline, split)
                known += found
    except OutOfTime:
        left_out.append("clocks and counters of the frames")
    return baseline, tuple(known)


def _hurried(budget: Budget, since_s: float, world: World, split: Split, left_out: list[str]) -> Fit:
    """A baseline in a few steps without impacts; where not even that is possible, the model as it is."""
    data, start = make_data(world, split), world.space.vector()
    try:
        with budget.limit(_CLOCKS_SHARE, since_s):
            return fit(data, start, world.baseline_names(), iterations=HURRIED_STEPS)
    except OutOfTime:
        left_out.append("baseline")
    return fit(data, start, (), iterations=0)
