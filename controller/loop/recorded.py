"""Exact conversion between the controller's step and the recording's topics, in both directions."""

from collections import deque
from collections.abc import Iterable, Iterator
from math import isfinite, nan
from typing import NamedTuple

from msgspec import structs

from stillarm.common.datagrams.messages import Adjustment
from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.configuration import Controller
from stillarm.common.recording.topics import EstimateSample, FastSample, FrameSample, SettingsSample
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.loop.step import CycleOutput
from stillarm.controller.safety.adjusting import Adjusted


def fast_sample(read: CycleInput, answered: CycleOutput, cycle_s: float) -> FastSample:
    """The input of a cycle, and its command."""
    return FastSample(
        time_s=read.cycle * cycle_s,
        cycle=read.cycle,
        acceleration_m_s2=read.acceleration_m_s2,
        joint_velocity_command_rad_s=answered.command_rad_s,
        joint_velocity_reference_rad_s=read.reference_rad_s,
        joint_position_rad=read.joint_position_rad,
        joint_velocity_rad_s=read.joint_velocity_rad_s,
        joint_age_s=read.joint_age_s,
        deflection_m=read.deflection_m,
        damping_allowed=read.damping_allowed,
        operator=read.operator,
    )


def estimate_sample(cycle: int, answered: CycleOutput, cycle_s: float) -> EstimateSample:
    """The estimate and prediction of a cycle."""
    estimate = answered.estimate
    return EstimateSample(
        cycle * cycle_s,
        cycle,
        estimate.delay.delay_s,
        estimate.delay.std_s,
        estimate.delay.status,
        estimate.deflection_m,
        estimate.deflection_std_m,
        answered.predicted_deflection_m,
        answered.damping_rad_s,
        answered.damping_status,
        answered.state,
        answered.reason or "",
        estimate.status,
        estimate.reason,
        estimate.trusted,
    )


def frame_sample(sample: VisualSample, cycle: int, cycle_s: float) -> FrameSample:
    """A visual sample with the cycle that read it."""
    return FrameSample(
        time_s=cycle * cycle_s,
        cycle=cycle,
        frame=sample.frame,
        received_s=cycle * cycle_s,
        started_s=sample.started_cycle * cycle_s if sample.started_cycle >= 0 else nan,
        started_cycle=sample.started_cycle,
        status=sample.status,
        displacement_px=sample.displacement_x_px,
        displacement_y_px=sample.displacement_y_px,
        rotation_rad=sample.rotation_rad,
        variance_x_px2=sample.variance_x_px2,
        variance_y_px2=sample.variance_y_px2,
        covariance_xy_px2=sample.covariance_xy_px2,
        variance_rotation_rad2=sample.variance_rotation_rad2,
        captured_s=sample.captured_s,
        exposure_s=sample.exposure_s,
        features=sample.features,
        inliers=sample.inliers,
        restarted=sample.restarted,
    )


def settings_sample(
    cycle: int, cycle_s: float, settings: Controller, adjusted: Adjusted | None
) -> SettingsSample:
    """The settings in force, and the answer to an adjustment if there was one."""
    asked = adjusted.asked if adjusted is not None else NOTHING_ASKED
    return SettingsSample(
        cycle * cycle_s,
        cycle,
        settings.method,
        settings.damping.added_damping_ratio,
        asked.method,
        asked.added_damping_ratio,
        adjusted.refused if adjusted is not None else "",
    )


def adjustments(settings: Iterable[SettingsSample]) -> dict[int, Adjustment]:
    """What the operator asked for, by cycle."""
    asked = {row.cycle: Adjustment(row.asked_method, row.asked_added_damping_ratio) for row in settings}
    return {cycle: one for cycle, one in asked.items() if one.method or isfinite(one.added_damping_ratio)}


NOTHING_ASKED = Adjustment("", nan)


def visual_sample(frame: FrameSample) -> VisualSample:
    """The visual sample of a recorded frame."""
    return VisualSample(
        frame.frame,
        frame.started_cycle,
        frame.status,
        frame.displacement_px,
        frame.displacement_y_px,
        frame.rotation_rad,
        frame.variance_x_px2,
        frame.variance_y_px2,
        frame.covariance_xy_px2,
        frame.variance_rotation_rad2,
        frame.captured_s,
        frame.exposure_s,
        frame.features,
        frame.inliers,
        frame.restarted,
    )


_NEVER = 2**63


class RecordedCycle(NamedTuple):
    """One recorded cycle: the step's input, the command, and the recorded rows.

    command_rad_s: NaN if none was recorded. row: None for a cycle with frames only. Times in the rows are as recorded;
    those of an import need not lie on the cycle's grid.
    """

    read: CycleInput
    command_rad_s: float
    row: FastSample | None
    frames: list[FrameSample]


def earliest_cycle(fast: Iterable[FastSample], frames: Iterable[FrameSample]) -> int:
    """The first cycle in a recording, of a row or of a frame's start; 0 if it has none."""
    begun = (frame.started_cycle for frame in frames if isfinite(frame.started_s))
    return min(min((row.cycle for row in fast), default=0), min(begun, default=_NEVER))


def recorded_cycles(
    fast: Iterable[FastSample], frames: Iterable[FrameSample], first_cycle: int = 0
) -> Iterator[RecordedCycle]:
    """The recorded cycles as the step received them, counted from `first_cycle`.

    A frame whose cycle has no row (an import at a lower rate; a lost row) is read in that cycle, without other
    measurements. The first of two rows in one cycle counts, also after a clock that stepped back.
    """
    waiting = deque(sorted(frames, key=lambda frame: frame.cycle))
    last = None
    command = nan
    for row in fast:
        if last is not None and row.cycle <= last:
            continue
        while waiting and waiting[0].cycle < row.cycle and last is not None:
            seen = _frames_of(waiting, waiting[0].cycle)
            yield RecordedCycle(_frames_alone(seen, first_cycle), command, None, seen)
        last, command = row.cycle, row.joint_velocity_command_rad_s
        seen = _frames_of(waiting, row.cycle)
        yield RecordedCycle(_cycle_input(row, seen, first_cycle), command, row, seen)


def _frames_of(waiting: deque[FrameSample], up_to_cycle: int) -> list[FrameSample]:
    """Remove the frames up to a cycle from the queue."""
    seen = []
    while waiting and waiting[0].cycle <= up_to_cycle:
        seen.append(waiting.popleft())
    return seen


def _counted_from(first_cycle: int, frames: list[FrameSample]) -> list[VisualSample]:
    samples = [visual_sample(frame) for frame in frames]
    if first_cycle == 0:
        return samples
    return [
        structs.replace(sample, started_cycle=sample.started_cycle - first_cycle)
        if isfinite(frame.started_s)
        else sample
        for frame, sample in zip(frames, samples, strict=True)
    ]


def _frames_alone(frames: list[FrameSample], first_cycle: int) -> CycleInput:
    return CycleInput(frames[0].cycle - first_cycle, samples=_counted_from(first_cycle, frames))


def _cycle_input(row: FastSample, frames: list[FrameSample], first_cycle: int) -> CycleInput:
    reference = row.joint_velocity_reference_rad_s
    return CycleInput(
        row.cycle - first_cycle,
        row.acceleration_m_s2,
        row.joint_position_rad,
        row.joint_velocity_rad_s,
        row.joint_age_s,
        reference if isfinite(reference) else 0.0,
        row.damping_allowed,
        _counted_from(first_cycle, frames),
        row.deflection_m,
        row.operator,
    )
