"""Runs the step functions on recorded data, as they ran live."""

import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from math import isnan
from typing import Any

import msgspec

from stillarm.common.files.configuration import Configuration, default_configuration_path
from stillarm.common.files.effects import declared
from stillarm.common.files.model import Model, check_model, length_of
from stillarm.common.files.typed_toml import parse_toml
from stillarm.common.recording.reader import Recording
from stillarm.common.recording.topics import EstimateSample, FastSample, FrameSample, SettingsSample
from stillarm.controller.estimation.estimate import DelayEstimate, Estimate, Method
from stillarm.controller.estimation.methods import MethodFactory, make_method
from stillarm.controller.loop.recorded import (
    RecordedCycle,
    adjustments,
    earliest_cycle,
    estimate_sample,
    fast_sample,
    recorded_cycles,
)
from stillarm.controller.loop.step import Controller
from stillarm.controller.replay.followed_method import FollowedMethod
from stillarm.controller.replay.frame_delays import FrameDelays
from stillarm.controller.safety.table import Event, Operator, State

_REPORT_EVERY = 1000  # cycles


@dataclass(frozen=True)
class RecordedRun:
    """A recording in memory, with its configuration and model."""

    name: str
    configuration: Configuration
    model: Model
    fast: list[FastSample]
    frames: list[FrameSample]
    estimates: list[EstimateSample]
    settings: list[SettingsSample] = field(default_factory=list)

    @property
    def cycle_s(self) -> float:
        """The controller's cycle, s."""
        return self.model.timing.cycle_s

    def cycles(self, first_cycle: int = 0) -> Iterator[RecordedCycle]:
        """The cycles as the step received them, counted from `first_cycle`."""
        return recorded_cycles(self.fast, self.frames, first_cycle)


@dataclass
class MethodRun:
    """One method's estimates, by cycle and by frame; times as recorded."""

    method: str
    times_s: list[float] = field(default_factory=list)
    estimates: list[Estimate] = field(default_factory=list)
    # frame, received_s, its delay
    frames: list[tuple[int, float, DelayEstimate]] = field(default_factory=list)


@dataclass
class LiveComparison:
    """Comparison of a replayed controller with its recording: number of cycles, and of those that differ."""

    cycles: int = 0
    different: int = 0
    first_difference: str | None = None

    @property
    def identical(self) -> bool:
        """Whether all numbers are identical."""
        return self.different == 0


def read_run(recording: Recording) -> RecordedRun:
    """Read a recording's messages, configuration and model. Raises UserError for invalid contents."""
    header, name = recording.header, str(recording.path)
    text = header.configuration or default_configuration_path().read_text()
    configuration = parse_toml(text, Configuration, f"{name} (configuration)")
    model = check_model(parse_toml(header.model, Model, f"{name} (model)"), f"{name} (model)")

    def topic(topic_name: str) -> list[Any]:
        return list(recording.messages(topic_name)) if recording.counts.get(topic_name) else []

    channels = (topic("/fast"), topic("/frames"), topic("/estimate"), topic("/settings"))
    run = RecordedRun(name, configuration, model, *channels)
    return run if _says_arm_at_start(text) else _with_permission_as_recorded(run)


def _says_arm_at_start(configuration_text: str) -> bool:
    return "arm_at_start" in tomllib.loads(configuration_text).get("controller", {})


def _with_permission_as_recorded(run: RecordedRun) -> RecordedRun:
    """The run with controller.arm_at_start as it was live. The key's default was true in the past, and is false now.

    It was true if the joint could move before an operator armed it. In recordings older than the states, the joint
    could always move.
    """
    asked = next((row.cycle for row in run.fast if row.operator & Operator.ARM), None)
    moved = next((estimate.cycle for estimate in run.estimates if estimate.state in _PERMITTED), None)
    by_itself = moved is not None and (asked is None or moved < asked)
    settings = msgspec.structs.replace(run.configuration.controller, arm_at_start=by_itself)
    return replace(run, configuration=msgspec.structs.replace(run.configuration, controller=settings))


_PERMITTED = ("", State.ARMED, State.DAMPING, State.DEGRADED)


def replay_method(
    run: RecordedRun,
    method: str,
    progress: Callable[[float], None] = lambda done: None,
    make: MethodFactory | None = None,
) -> MethodRun:
    """Run a method on recorded measurements and commands. Raises UserError for an unknown method or a missing length.

    make: makes the method, where none of that name is installed.

    The method counts from the recording's first cycle, so that a clock that starts in 1970, or below zero, makes no
    difference.
    """
    name = f"{run.name} (model)"
    model = declared(run.model)
    length = length_of(model, name)

    def begun() -> Method:
        settings = run.configuration.controller
        return make(model, settings, name) if make is not None else make_method(method, model, settings, name)

    followed = FollowedMethod(begun, model, length)
    result, delays = MethodRun(method), FrameDelays()
    first_cycle = earliest_cycle(run.fast, run.frames)
    for count, cycle in enumerate(run.cycles(first_cycle)):
        estimate = followed.step(cycle)
        if cycle.row is not None:
            result.times_s.append(cycle.row.time_s)
            result.estimates.append(estimate)
        result.frames.extend((frame.frame, frame.received_s, estimate.delay) for frame in cycle.frames)
        for place, delay in delays.told(cycle.read.samples, estimate):
            result.frames[place] = (*result.frames[place][:2], delay)
        if count % _REPORT_EVERY == 0:
            progress(count / max(1, len(run.fast)))
    return result


def compare_with_live(run: RecordedRun) -> LiveComparison:
    """Run the recorded controller again, and compare every estimate, prediction and command with the recording."""
    refused = any(estimate.reason == Event.UNCOMMISSIONED for estimate in run.estimates)
    controller = Controller(
        run.model,
        run.configuration.controller,
        f"{run.name} (model)",
        identified_only=refused,  # as it was live; in older recordings of a rig it was not
    )
    comparison = LiveComparison()
    recorded = {estimate.cycle: estimate for estimate in run.estimates}
    asked = adjustments(run.settings)
    for read, _, row, _ in run.cycles():
        read.adjustment = asked.get(read.cycle)
        answered = controller.step(read)
        if row is None:
            continue
        comparison.cycles += 1
        wanted = recorded.get(read.cycle)
        found = estimate_sample(read.cycle, answered, run.cycle_s)
        pairs = list(_numbers(wanted, found)) if wanted is not None else []
        pairs += _numbers(row, fast_sample(read, answered, run.cycle_s))
        different = [
            f"{key}: {was!r} live, {now!r} replayed" for key, was, now in pairs if not _same(was, now)
        ]
        if different:
            comparison.different += 1
            if comparison.first_difference is None:
                comparison.first_difference = f"cycle {read.cycle}, {different[0]}"
    return comparison


def _numbers(was: object, now: msgspec.Struct) -> Iterator[tuple[str, object, object]]:
    # time_s follows from the cycle, unless a simulated clock stepped; before there were states, none was recorded
    passed = {"time_s", "state", "reason"} if getattr(was, "state", None) == "" else {"time_s"}
    if getattr(was, "trust", None) == "":  # recorded before estimates had a trust
        passed.add("trust")
    for key in now.__struct_fields__:
        if key not in passed:
            yield key, getattr(was, key), getattr(now, key)


def _same(was: object, now: object) -> bool:
    if isinstance(was, float) and isinstance(now, float) and isnan(was) and isnan(now):
        return True
    return was == now
