"""Clocks that were set, and queues that hold images back: found in the baseline, and taken back.

The camera's own clock: its stamps step against the requests and the arrivals alike. If it was the computers' clock that
was set, requests and arrivals step against the stamps just so, and the images keep to the stamps: what they show tells
which of the two it was.

A triggered camera's queue that from some instant on holds more images than it did: each comes as late after its own
request as the further ones take, and shows what it was asked for. Nothing but the arrivals tells, by a step for good of
whole frames beside a delay that wanders. A clock that was set would show in the requests, too, and leave the time
between the two alone; where the images have stamps of their own, the requests would step against those.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import hypot

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.frame_times import (
    MOST_HELD,
    ArrivalStep,
    Held,
    arrival_step,
    held_back,
    set_stamps,
    taken_back,
    without,
)
from stillarm.diagnosis.data.measured import ClockGap, Frames, Measured, reclocked
from stillarm.diagnosis.data.robust import SIDE, WHOLE, step_at
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.events.impacts import fit_with_impacts
from stillarm.diagnosis.fitting.fit import CHANGED_NATS, WANDER_S, fit
from stillarm.diagnosis.fitting.fitted import Data, Fit, carried_over, gain_of_each_block, make_data
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.sensors.laws import OF_STAMPS, LawFound

Array = NDArray[np.float64]

_ONE_STEP_S = 1.0  # steps nearer each other are parts of one
_RECLOCKED_NATS = 10.0  # by which the frames have to fit better without a gap in time_s: 20 000 to 1
_MOST_GAPS = 3  # that are taken back, the longest first: each asks for a fit with impacts
_MANY_GAPS, _AS_LONG = 4, 3.0  # other gaps, of which the longest is one if within so many medians
_REPEATED = "captured_s comes twice: the buffer hands over the stamp with the old image"
_QUEUED = "received_s steps by whole frames, started_s does not: each image is handed over that much later"
_ASIDE_S = 0.4  # on either side of a gap, where its frames are compared: four at 10 Hz

# a longer queue
_SURE = 2.0  # standard deviations of the step: 19 of 20 steps by whole frames lie within
_ALIKE, _FEWEST = 0.25, 5  # of the step; frames on either side


def without_steps(baseline: Fit, split: Split) -> tuple[Fit, list[LawFound]]:
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


def without_old_images(baseline: Fit, split: Split) -> tuple[Fit, list[LawFound]]:
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


def without_set_stamps(baseline: Fit, split: Split) -> tuple[Fit, list[LawFound]]:
    """The baseline with the stamps that date a triggered camera's images those of a clock that was never set, if the
    images say that it was."""
    world = baseline.world
    frames, clock = world.measured.frames, world.frame_clock
    if clock.counted or clock.arrival or "displacement" not in world.channels:
        return baseline, []
    step = set_stamps(frames, WANDER_S / world.step_s("displacement"))
    if step is None:
        return baseline, []
    other = fit_with_impacts(world.with_measured(taken_back(world.measured, step), ()), split)
    gains = gain_of_each_block(other, baseline)
    gained = float(gains.sum())
    onset = float(frames.received_s[step.first]), world.step_s("displacement")
    law = LawFound("clock_step", {"onset_s": onset, "step_s": (step.step_s, step.std_s)}, gains, OF_STAMPS)
    return (other, [law]) if gained > CHANGED_NATS else (baseline, [])


def late_queue(baseline: Fit) -> Held | None:
    """The first frame that the longer queue delays, and by how many frames, if the arrivals step so."""
    world = baseline.world
    frames = world.measured.frames
    step = step_of_arrivals(baseline)
    if step is None or not (frames.asked or _requests_keep_to_stamps(frames, step)):
        return None
    rate_hz = world.model.camera.frame_rate_hz
    size, noted = step.step_s * rate_hz, world.measured.cycle_s * rate_hz
    doubt, held = hypot(step.std_s * rate_hz, 0.5 * noted), round(size)
    whole = doubt < WHOLE and abs(size - held) < _SURE * doubt
    return Held(step.index, held) if whole and 1 <= held <= MOST_HELD else None


def _requests_keep_to_stamps(frames: Frames, step: ArrivalStep) -> bool:
    """Whether both are known about a step, and go on alike there."""
    apart = frames.started_s - frames.captured_s
    before, after = apart[max(0, step.index - SIDE) : step.index], apart[step.index : step.index + SIDE]
    if min(np.isfinite(before).sum(), np.isfinite(after).sum()) < _FEWEST:
        return False
    return abs(step_at(apart, step.index, SIDE)) < _ALIKE * abs(step.step_s)


def step_of_arrivals(last: Fit) -> ArrivalStep | None:
    """The step that a fit's arrivals show beside a wander of the delay; None where they were not measured, or show
    none."""
    arrivals = last.channel("arrival")
    if arrivals is None:
        return None
    return arrival_step(arrivals.off, WANDER_S / last.world.step_s("arrival"))


def backward_steps(data: Data) -> list[LawFound]:
    """time_s stepped back: no cause but the clock can do that."""
    found = []
    measured = data.world.measured
    for gap in measured.backward:
        found.append(_of_gap(data, gap))
    return as_one(found)


def forward_step(gap: ClockGap, measured: Measured, gains: Array) -> LawFound:
    """time_s jumped on although no row is missing: gains of each block by taking the jump back."""
    return LawFound(
        "clock_step",
        {
            "onset_s": (gap.cycle * measured.cycle_s, measured.cycle_s),
            "step_s": (gap.extra_s, measured.cycle_s),
        },
        gains,
        note="time_s itself steps, in both files",
    )


def as_one(steps: list[LawFound]) -> list[LawFound]:
    """Steps within a second of each other are one, in parts: the first one's onset, all their lengths."""
    merged: list[LawFound] = []
    for step in sorted(steps, key=lambda one: one.values["onset_s"][0]):
        last = merged[-1] if merged else None
        if last is None or step.values["onset_s"][0] - last.values["onset_s"][0] > _ONE_STEP_S:
            merged.append(step)
            continue
        length, doubt = last.values["step_s"]
        values = last.values | {"step_s": (length + step.values["step_s"][0], doubt)}
        merged[-1] = replace(last, values=values, held_out_score=last.held_out_score + step.held_out_score)
    return merged


def _of_gap(data: Data, gap: ClockGap) -> LawFound:
    measured = data.world.measured
    blocks = np.full(len(data.split.held), 1000.0 / len(data.split.held))
    return LawFound(
        "clock_step",
        {
            "onset_s": (gap.cycle * measured.cycle_s, measured.cycle_s),
            "step_s": (gap.extra_s, measured.cycle_s),
        },
        blocks,
        note="time_s itself steps, in both files",
    )
