"""One call: measured data in, diagnosis out. docs/diagnosis.md tells how it decides."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import tomli_w

from stillarm.common.files.effects import declared
from stillarm.common.files.model import Model, check_model
from stillarm.common.files.typed_toml import parse_toml
from stillarm.common.recording.reader import Recording, open_recording
from stillarm.common.user_error import UserError
from stillarm.diagnosis import tables as say
from stillarm.diagnosis.affordable import affordable
from stillarm.diagnosis.budget import Budget, OutOfTime, unlimited
from stillarm.diagnosis.candidate import Found
from stillarm.diagnosis.ceiling import below, ceiling_of
from stillarm.diagnosis.channels import without_dead_sensors
from stillarm.diagnosis.decide import Judged, judge
from stillarm.diagnosis.declared_effects import with_found
from stillarm.diagnosis.explain import explain
from stillarm.diagnosis.extended_model import baseline_changes, effect_of, refitted_model
from stillarm.diagnosis.fit import CHANGED_NATS, Fit, Split, fit, gain_of_each_block, make_data
from stillarm.diagnosis.frequency_course import frequency_courses, seen_frequency
from stillarm.diagnosis.image_dating import dated
from stillarm.diagnosis.impacts import (
    carried_over,
    fit_with_impacts,
    with_impacts_in_place,
    with_impacts_sought,
)
from stillarm.diagnosis.late_queue import late_queue
from stillarm.diagnosis.laws import LawFound, as_one, forward_step
from stillarm.diagnosis.lost_modes import with_lost_modes
from stillarm.diagnosis.measured import ClockGap, Measured, first_part, read_measured, reclocked
from stillarm.diagnosis.measured_joint import departure_hz
from stillarm.diagnosis.pair_start import with_resonance_of
from stillarm.diagnosis.pulls import pull_spans_s
from stillarm.diagnosis.quantities import RANGE
from stillarm.diagnosis.recount import recounted
from stillarm.diagnosis.repeated_stamps import held_back, without
from stillarm.diagnosis.set_stamps import without_set_stamps
from stillarm.diagnosis.split import interleaved, stated
from stillarm.diagnosis.world import World

Tick = Callable[[float, str], None]

_RECLOCKED_NATS = 10.0
_MOST_GAPS = 3
_MANY_GAPS, _AS_LONG = 4, 3.0
_SHORTEST_S, _FEWEST_PAIRS = 3.0, 128  # of a recording; samples of a pair
_BASELINE_SHARE, _CLOCKS_SHARE = 0.45, 0.6  # of the time for all stages
_JUDGED_SHARE = 1.15  # of what the stages may take: the verdict's share of the budget holds as much
_HURRIED_STEPS = 5
_PULLS_SOUGHT = 2
_REPEATED = "captured_s comes twice: the buffer hands over the stamp with the old image"
_QUEUED = "received_s steps by whole frames, started_s does not: each image is handed over that much later"
_ASIDE_S = 0.4
_MOVED, _MUCH = 0.003, 3.0  # of the frequency; of the stated noise
_LIMIT_KNOWN = 0.97  # of the stated range: an accelerometer at that limit is simulated as it is


@dataclass(frozen=True)
class Diagnosis:
    """The result: `table` is what diagnosis.json holds; the rest is for the report."""

    table: dict[str, Any]
    found: Found
    judged: Judged
    split: Split
    model: Model
    extended: Model


def model_of(recording: Recording) -> Model:
    """The model that the recording carries. Raises UserError."""
    text = recording.header.model
    if not text.strip():
        return Model()
    return check_model(
        parse_toml(text, Model, f"{recording.path} (its model)"), f"{recording.path} (its model)"
    )


def diagnose(
    path: str | Path,
    model: Model | None = None,
    hold_out: Sequence[tuple[float, float]] = (),
    tick: Tick = lambda done, what: None,
    budget: Budget | None = None,
) -> Diagnosis:
    """Diagnose one recording. Raises UserError where it holds too little."""
    budget = budget or unlimited()
    recording = open_recording(path)
    given = model is not None or bool(recording.header.model.strip())
    model = model or model_of(recording)
    tick(0.02, "reading")
    measured = read_measured(recording, model)
    if measured.pair and measured.cycles < _FEWEST_PAIRS:
        raise UserError(
            f"{path}: {measured.cycles} samples are too few for a diagnosis; give at least {_FEWEST_PAIRS}"
        )
    if measured.duration_s < _SHORTEST_S and not measured.pair:
        raise UserError(
            f"{path}: {measured.duration_s:.1f} s are too short for a diagnosis; record 20 s or more"
        )
    if measured.pair and not given:
        model = with_resonance_of(measured, model)
    return diagnose_measured(measured, model, hold_out, tick, budget)


def diagnose_measured(
    measured: Measured,
    model: Model,
    hold_out: Sequence[tuple[float, float]] = (),
    tick: Tick = lambda done, what: None,
    budget: Budget | None = None,
) -> Diagnosis:
    """Diagnose data that are already in memory. Raises UserError where they show nothing."""
    budget = budget or unlimited()
    model = declared(model)
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
    with budget.limit():
        found = explain(baseline, split, lambda done, what: tick(0.1 + 0.75 * done, what), known=known)
    tick(0.92, "what is left")
    with budget.limit(_JUDGED_SHARE):
        judged = judge(found, split)
    left_out += [*dict.fromkeys(found.left_out), *judged.left_out]
    if judged.verdict == "none":
        found.findings, found.final = [], found.baseline
    extended = refitted_model(model, found.final)
    effects = [effect_of(one, found.final) for one in found.findings]
    extended = msgspec.structs.replace(extended, effects=with_found(model.effects, effects))
    table = {
        "verdict": judged.verdict,
        "channels": say.channel_table(found, split),
        "findings": say.findings_table(found, judged, split),
        "unexplained": say.unexplained_table(judged),
        "left": say.left_table(judged),
        "events": say.events_table(found),
        "looked_at": {"seconds": budget.used_s, "budget_s": budget.seconds, "left_out": left_out},
        "channels_left_out": unused,
        "baseline_changes": baseline_changes(model, found.final),
        "extended_model": "extended.toml",
    }
    return Diagnosis(table, found, judged, split, model, extended)


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
    plain: Fit | None = None
    try:
        with budget.limit(_BASELINE_SHARE, since_s):
            world = _moved_as_measured(world, split)
            plain = fit(make_data(world, split), world.space.vector(), world.baseline_names())
            baseline = _without_pulls(_baseline(world, split), split)
    except OutOfTime:
        left_out.append("impacts")
        return plain or _hurried(budget, since_s, world, split, left_out), ()
    known: list[LawFound] = []
    try:
        with budget.limit(_CLOCKS_SHARE, since_s):
            baseline = recounted(dated(baseline, split), split)
            baseline = with_lost_modes(baseline, split)
            for mended in (_without_steps, without_set_stamps, _without_old_images):
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
            return fit(data, start, world.baseline_names(), iterations=_HURRIED_STEPS)
    except OutOfTime:
        left_out.append("baseline")
    return fit(data, start, (), iterations=0)


def _moved_as_measured(world: World, split: Split) -> World:
    """The world in which the arm is moved by the joint as it was measured, where the drive's model does not foretell
    it."""
    if "joint_position" not in world.channels or world.measured.pair:
        return world
    names = [name for name in world.baseline_names() if name.startswith("start.")]
    begun = fit(make_data(world, split), world.space.vector(), names, iterations=_HURRIED_STEPS)
    simulated = world.reported_position(begun.vector)
    return world.changed(joint_hz=departure_hz(world.measured.position, simulated, world.measured.cycle_s))


def _without_pulls(baseline: Fit, split: Split) -> Fit:
    """The baseline with what held the arm for a while left out, and impacts sought once more: beside a pull none that
    is less than it shows."""
    cycle_s = baseline.world.measured.cycle_s
    for _ in range(_PULLS_SOUGHT):
        spans = pull_spans_s(baseline)
        if not spans:
            break
        inside = [
            i for i in baseline.world.impacts if any(a <= i * cycle_s < b - 2.0 * cycle_s for a, b in spans)
        ]
        kept = tuple(i for i in baseline.world.impacts if i not in inside)
        unjudged_s = tuple(sorted({*baseline.world.unjudged_s, *spans}))
        world = baseline.world.changed(impacts=kept, unjudged_s=unjudged_s)
        baseline = fit_with_impacts(world, split, carried_over(baseline, world))
    return baseline


def _baseline(world: World, split: Split) -> Fit:
    """The baseline's fit; where the accelerometer is at a limit that it should not have, started from that of a sensor
    with such a limit."""
    acceleration = world.channels.get("acceleration")
    if acceleration is not None:
        ceiling = ceiling_of(acceleration, world.model.accelerometer.noise_std_m_s2)
        if ceiling is not None and ceiling < _LIMIT_KNOWN * world.model.accelerometer.range_m_s2:
            limited = _with_limit(world, split, ceiling)
            there = limited.world
            start = there.space.with_values(limited.vector, {RANGE: there.space[RANGE].start})
            return fit(make_data(there, split), start, there.baseline_names())
    return _along_a_course(world, split) or _at_the_seen_frequency(world, split)


def _with_limit(world: World, split: Split, ceiling: float) -> Fit:
    """The baseline's fit of a sensor with that limit, m/s^2: with the impacts that what lies below it shows, or with
    those that show once its limit is simulated from there: a vibration is below it long after the impact."""
    below_it = fit_with_impacts(world.with_measured(below(world.measured, ceiling), ()), split)
    there = world.changed(impacts=below_it.world.impacts)
    start = there.space.with_values(carried_over(below_it, there), {RANGE: ceiling})
    kept = fit(make_data(there, split), start, there.baseline_names())
    sought = fit_with_impacts(
        world, split, world.space.with_values(carried_over(kept, world), {RANGE: ceiling})
    )
    return max(kept, sought, key=lambda one: one.train_log_likelihood)


def _at_the_seen_frequency(world: World, split: Split) -> Fit:
    """The baseline's fit; where its frequency is far from the one that the vibration has from window to window, it is
    stuck between the model's and the true one, and is begun again from there; so it is from its own, if that is not
    what its impacts were sought with and much is left."""
    usual = fit_with_impacts(world, split)
    fitted = usual.value("modes.0.frequency_hz")
    hz = seen_frequency(world, usual.predicted.motion, fitted)
    if hz is None and _left_by_a_wrong_start(usual):
        hz = fitted
    if hz is None:
        return usual
    begun = world.space.with_values(world.space.vector(), {"modes.0.frequency_hz": hz})
    other = fit_with_impacts(world, split, begun)
    return other if other.train_log_likelihood > usual.train_log_likelihood + CHANGED_NATS else usual


def _left_by_a_wrong_start(usual: Fit) -> bool:
    """Whether a fit has gone far from the frequency that its impacts were sought with, and leaves far more than the
    accelerometer's noise: at a wrong frequency they are found late, and where there are none."""
    world = usual.world
    sensor = usual.channel("acceleration")
    if not world.impacts or sensor is None:
        return False
    moved = abs(usual.value("modes.0.frequency_hz") / world.space["modes.0.frequency_hz"].start - 1.0)
    return moved > _MOVED and sensor.sigma > _MUCH * world.model.accelerometer.noise_std_m_s2


def _along_a_course(world: World, split: Split) -> Fit | None:
    """Where the arm's frequency plainly changes, any one frequency hides the impacts in a part of the recording and
    makes up others: the baseline's fit with the impacts that are seen with its course. None where one frequency
    does."""
    begun = world.space.vector()
    courses = frequency_courses(world, world.predict(begun).motion)
    if not courses:
        return None
    course = max(courses.values(), key=lambda one: one.nats)
    starts = course.starts(world)
    sought = with_impacts_sought(world, split, world.space.with_values(begun, starts[0]))
    if _steady_with_impacts_of(_likeliest(sought, split, starts[1:]), split, starts[0]) is None:
        return None  # before its impacts are put in place, which takes long
    struck = with_impacts_in_place(sought, split)
    return _steady_with_impacts_of(_likeliest(struck, split, starts[1:]), split, starts[0])


def _likeliest(struck: Fit, split: Split, starts: Sequence[dict[str, float]]) -> Fit:
    """The fit, or one of those with its impacts from these starts."""
    there = struck.world
    data, names = make_data(there, split), there.baseline_names()
    others = [fit(data, there.space.with_values(struck.vector, one), names) for one in starts]
    return max((struck, *others), key=lambda one: one.train_log_likelihood)


def _steady_with_impacts_of(seen: Fit, split: Split, course: Iterable[str]) -> Fit | None:
    """The fit of one frequency with the impacts that are seen with a course of these quantities; None where it does as
    well."""
    there = seen.world
    usual = {name: there.space[name].start for name in course}
    start = there.space.with_values(seen.vector, usual)
    one = fit(make_data(there, split), start, there.baseline_names())
    return one if seen.train_log_likelihood - one.train_log_likelihood > CHANGED_NATS else None


def _without_steps(baseline: Fit, split: Split) -> tuple[Fit, list[LawFound]]:
    """The baseline with every jump of time_s that was no loss of rows, but a clock that was set, taken back."""
    steps: list[LawFound] = []
    tried: set[float] = set()
    while len(tried) < _MOST_GAPS:
        measured = baseline.world.measured
        gap = max((g for g in measured.gaps if g.extra_s not in tried), key=_length, default=None)
        if gap is None or _one_of_many(gap, measured.gaps):
            break
        tried.add(gap.extra_s)
        if _frames_go_on(baseline.world, gap):
            continue
        other = fit_with_impacts(baseline.world.with_measured(reclocked(measured, gap), ()), split)
        gains = other.held_out_score - baseline.held_out_score
        gained = other.train_log_likelihood - baseline.train_log_likelihood + float(gains.sum())
        if gained > _RECLOCKED_NATS:
            steps.append(forward_step(gap, measured, gains))
            baseline = other
    return baseline, as_one(steps)


def _without_old_images(baseline: Fit, split: Split) -> tuple[Fit, list[LawFound]]:
    """The baseline with the frames of a triggered camera whose images have instants of their own, stamps or requests,
    read as early as before a buffer held them back."""
    world = baseline.world
    if world.frame_clock.counted or world.frame_clock.arrival:
        return baseline, []
    period = 1.0 / world.model.camera.frame_rate_hz
    frames = world.measured.frames
    repeated = held_back(frames, period)
    held = repeated or late_queue(baseline)
    if held is None:
        return baseline, []
    mended = world.with_measured(without(world.measured, held, period))
    other = fit(make_data(mended, split), carried_over(baseline, mended), mended.baseline_names())
    gains = gain_of_each_block(other, baseline)
    gained = float(gains.sum())
    onset = float((frames.received_s if repeated else frames.started_s)[held.first])
    law = LawFound(
        "stale_frame_buffer",
        {"onset_s": (onset, 0.5 * period), "frames": (float(held.frames), 0.0)},
        gains,
        note=_REPEATED if repeated else _QUEUED,
    )
    return (other, [law]) if gained > 0.0 else (baseline, [])


def _frames_go_on(world: World, gap: ClockGap) -> bool:
    """Whether frames of a freerunning camera arrive across a gap as if the time in it had truly passed."""
    if not world.frame_clock.counted:
        return False
    received = world.measured.frames.received_s
    late = received - world.frame_clock.grid_s
    at = gap.cycle * world.measured.cycle_s
    before = late[(received > at - gap.extra_s - _ASIDE_S) & (received < at - gap.extra_s)]
    after = late[(received >= at) & (received < at + _ASIDE_S)]
    if min(len(before), len(after)) < 4:
        return False
    return abs(float(np.median(after) - np.median(before)) - gap.extra_s) > 0.5 * gap.extra_s


def _one_of_many(gap: ClockGap, gaps: Sequence[ClockGap]) -> bool:
    """Whether the longest gap is as long as others are: rows were lost here and there, and no clock was set."""
    others = [one.extra_s for one in gaps if one != gap]
    return len(others) >= _MANY_GAPS and gap.extra_s <= _AS_LONG * float(np.median(others))


def _length(gap: ClockGap) -> float:
    return gap.extra_s


def model_text(model: Model) -> str:
    """A model file's text."""
    return tomli_w.dumps(_present(msgspec.to_builtins(model)))


def _present(value: Any) -> Any:
    """Without what is None: TOML has no such value."""
    if isinstance(value, dict):
        return {key: _present(one) for key, one in value.items() if one is not None}
    if isinstance(value, list):
        return [_present(one) for one in value]
    return value
