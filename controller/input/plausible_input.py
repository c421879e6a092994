"""Checks all values of a cycle in one place, before anything computes with them.

The bounds come from the model: the device's range, the joint's motion, the scene's motion, each with a margin for a
model that is wrong by a factor. A value beyond them is refused, counted, and treated as missing. A value within them is
kept: the estimators judge possible outliers.
"""

from dataclasses import replace
from enum import IntEnum
from math import isnan, nan
from typing import Any, NamedTuple

import msgspec

from stillarm.common.datagrams.visual_sample import FARTHEST_PX, TrackingStatus, VisualSample
from stillarm.common.files.model import Model
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.input.plausible_steps import PlausibleSteps
from stillarm.controller.safety.table import Operator

PAUSE_S = 1.0
"""After a longer pause the known motion is no longer valid and the histories are too short: everything restarts."""

MOST_CYCLE = 1 << 40  # 35 years of milliseconds; the resolution of the time is then 0.2 us
MOST_SAMPLES = 16  # per cycle: a backlog of a quarter of a second; each costs up to 0.1 ms
_OLDEST_SAMPLE_S = 2.5  # stillarm.controller.joint.joint_motion.HISTORY_S: length of the joint's history
_MOST_FRAME = 1 << 63
_MOST_STAMP_S = 1e12  # a camera's clock in s since any epoch; its resolution is then 0.1 ms
_OLDEST_REPORT_S = 1e6  # for a drive that never reported, as in stillarm.controller.loop.live_devices
_RANGES = 2.0  # an accelerometer is limited to its range, but the model's range may be wrong
_SPANS, _TURNS_RAD = 1.5, 12.6  # of the joint's range to either side of its middle; at least two turns
_LEAST_SCENE_PX = 4096.0  # at least an image's width, if the model's scale gives less
_BENDING = 0.5  # of the arm's length: upper bound of a beam's bending
_VELOCITIES, _REFERENCES = 10.0, 100.0  # of the drive's greatest velocity
_STEP_SPANS = 0.05  # of the joint's range, from one report to the next
_STEP_VELOCITIES = 2.0  # of the drive's greatest velocity, from one report to the next
_STEP_SCENE = 0.02  # of the scene's total motion, from one image to the next
_CONFIRMED_IMAGES, _CONFIRMED_S = 3, 0.05  # images, and time of reports, that agree on another level
_SWING = 0.05  # of the arm's length: amplitude of a large vibration


class Field(IntEnum):
    """The values that may be refused."""

    CYCLE = 0
    ACCELERATION = 1
    JOINT_POSITION = 2
    JOINT_VELOCITY = 3
    JOINT_AGE = 4
    REFERENCE = 5
    DAMPING_ALLOWED = 6
    DEFLECTION = 7
    OPERATOR = 8
    SAMPLES = 9  # too many in a cycle
    FRAME = 10
    STARTED_CYCLE = 11
    DISPLACEMENT = 12
    VARIANCE = 13
    CAPTURED = 14


class Admitted(NamedTuple):
    """A cycle with plausible values only. elapsed: cycles since the last one, at least 1.

    begin_anew: the loop paused for longer than PAUSE_S, the cycle number went back, or the zero of the joint's reports
    has changed.
    """

    read: CycleInput
    elapsed: int
    begin_anew: bool


class PlausibleInput:
    """Checks each cycle against the model and against the cycles before.

    refused: number of values refused since the start, by Field.
    """

    def __init__(self, model: Model, length_m: float) -> None:
        """length_m: length of the arm."""
        self._cycle_s = cycle_s = model.timing.cycle_s
        self.refused = [0] * len(Field)
        self._pause_cycles = round(PAUSE_S / cycle_s)
        self._oldest_cycles = round(_OLDEST_SAMPLE_S / cycle_s)
        drive, camera = model.drive, model.camera
        self._acceleration = _RANGES * model.accelerometer.range_m_s2
        self._velocity = _VELOCITIES * drive.max_velocity_rad_s
        self._reference = _REFERENCES * drive.max_velocity_rad_s
        self._deflection = length_m
        span = drive.max_position_rad - drive.min_position_rad
        middle_rad, reach_rad = 0.5 * (drive.max_position_rad + drive.min_position_rad), _SPANS * span
        widest_rad = max(reach_rad, _TURNS_RAD)
        self._lowest_rad, self._highest_rad = middle_rad - widest_rad, middle_rad + widest_rad
        px_per_m, px_per_rad = abs(camera.scale_px_per_m), abs(camera.rotation_px_per_rad)
        turn_rad = reach_rad + _BENDING
        scene_px = px_per_m * length_m * turn_rad + px_per_rad * turn_rad
        self._scene_px = min(max(scene_px, _LEAST_SCENE_PX), FARTHEST_PX)
        rad_s = _STEP_VELOCITIES * drive.max_velocity_rad_s
        swing = _SWING * length_m * model.arm.modes[0].angular_frequency
        px_s = px_per_m * (length_m * rad_s + swing) + px_per_rad * (rad_s + swing / length_m)
        reports = max(_CONFIRMED_IMAGES, round(_CONFIRMED_S / cycle_s))
        self._position_steps = PlausibleSteps(_STEP_SPANS * span, rad_s, reports)
        self._image_steps = PlausibleSteps(_STEP_SCENE * self._scene_px, px_s, _CONFIRMED_IMAGES)
        self._cycle: int | None = None
        self._age_s = nan
        self._frame = -1

    def admit(self, read: CycleInput) -> Admitted:
        """The cycle with implausible values made missing; the same object if all values are plausible."""
        cycle, elapsed, begin_anew = self._follow(read.cycle)
        if begin_anew:
            self._begin_anew()
        time_s = cycle * self._cycle_s
        changes: dict[str, Any] = {}
        if cycle != read.cycle:
            changes["cycle"] = cycle
        acceleration = read.acceleration_m_s2
        if not -self._acceleration <= acceleration <= self._acceleration and not _missing(acceleration):
            changes["acceleration_m_s2"] = self._refuse(Field.ACCELERATION)
        position = read.joint_position_rad
        self._position_steps.moved = False
        if not self._placed(position, time_s) and not _missing(position):
            changes["joint_position_rad"] = self._refuse(Field.JOINT_POSITION)
        velocity = read.joint_velocity_rad_s
        if not -self._velocity <= velocity <= self._velocity and not _missing(velocity):
            changes["joint_velocity_rad_s"] = self._refuse(Field.JOINT_VELOCITY)
        age = self._aged(read.joint_age_s, elapsed)
        if age is not read.joint_age_s:
            changes["joint_age_s"] = age
        if not -self._reference <= read.reference_rad_s <= self._reference:
            if not _missing(read.reference_rad_s):
                self._refuse(Field.REFERENCE)
            changes["reference_rad_s"] = 0.0
        deflection = read.deflection_m
        if not -self._deflection <= deflection <= self._deflection and not _missing(deflection):
            changes["deflection_m"] = self._refuse(Field.DEFLECTION)
        if read.damping_allowed not in _PERMISSIONS:
            self._refuse(Field.DAMPING_ALLOWED)
            changes["damping_allowed"] = False
        if read.operator:
            self._check_operator(read.operator, changes)
        if read.samples:
            self._check_samples(read.samples, cycle, time_s, changes)
        begin_anew = begin_anew or self._position_steps.moved
        return Admitted(replace(read, **changes) if changes else read, elapsed, begin_anew)

    def _refuse(self, which: Field) -> float:
        self.refused[which] += 1
        return nan

    def _follow(self, cycle: int) -> tuple[int, int, bool]:
        """The cycle's number, the cycles since the last one, and whether everything restarts."""
        last = self._cycle
        if type(cycle) is not int or not 0 <= cycle <= MOST_CYCLE:
            self._refuse(Field.CYCLE)
            cycle = 0 if last is None else last + 1
        self._cycle = cycle
        if last is None:
            return cycle, 1, False
        elapsed = cycle - last
        if elapsed <= 0:  # the length of the pause is unknown
            self._refuse(Field.CYCLE)
            return cycle, self._pause_cycles + 1, True
        return cycle, elapsed, elapsed > self._pause_cycles

    def _begin_anew(self) -> None:
        self._position_steps.restart()
        self._image_steps.restart()

    def _placed(self, position_rad: float, time_s: float) -> bool:
        within = self._lowest_rad <= position_rad <= self._highest_rad
        return within and self._position_steps.accepts(position_rad, time_s)

    def _aged(self, age_s: float, elapsed: int) -> float:
        """The report's age. A missing or impossible age grows from the last one: the drive counts as silent."""
        if 0.0 <= age_s <= _OLDEST_REPORT_S:
            self._age_s = age_s
            return age_s
        missing = _missing(age_s)
        if not missing:
            self._refuse(Field.JOINT_AGE)
        if age_s > _OLDEST_REPORT_S:
            return _OLDEST_REPORT_S
        if _missing(self._age_s):
            return age_s if missing else nan
        self._age_s = min(self._age_s + elapsed * self._cycle_s, _OLDEST_REPORT_S)
        return self._age_s

    def _check_operator(self, asked: int, changes: dict[str, Any]) -> None:
        whole = isinstance(asked, int)
        if whole and 0 < asked < _OPERATOR_END:
            return
        self._refuse(Field.OPERATOR)
        changes["operator"] = asked & Operator.EMERGENCY_STOP if whole else 0

    def _check_samples(
        self, samples: list[VisualSample], cycle: int, time_s: float, changes: dict[str, Any]
    ) -> None:
        """The newest samples, each with plausible values."""
        left_out = len(samples) - MOST_SAMPLES
        kept = samples
        if left_out > 0:
            self.refused[Field.SAMPLES] += left_out
            kept = samples[left_out:]
            if any(sample.restarted for sample in samples[:left_out]):
                kept[0] = msgspec.structs.replace(kept[0], restarted=True)
        checked = [self._sample(sample, cycle, time_s) for sample in kept]
        if left_out > 0 or any(now is not was for now, was in zip(checked, samples, strict=False)):
            changes["samples"] = checked

    def _sample(self, sample: VisualSample, cycle: int, time_s: float) -> VisualSample:
        changes: dict[str, Any] = {}
        if sample.restarted:
            self._image_steps.restart()
        frame = sample.frame
        if type(frame) is not int or not 0 <= frame < _MOST_FRAME:
            self._refuse(Field.FRAME)
            frame = changes["frame"] = self._frame + 1
        self._frame = frame
        started = sample.started_cycle
        if started != -1 and (type(started) is not int or not 0 <= cycle - started <= self._oldest_cycles):
            self._refuse(Field.STARTED_CYCLE)
            changes["started_cycle"] = -1
        if sample.status == TrackingStatus.MEASURED:
            displacement, steps = sample.displacement_x_px, self._image_steps
            if not (abs(displacement) <= self._scene_px and steps.accepts(displacement, time_s)):
                changes["displacement_x_px"] = self._refuse(Field.DISPLACEMENT)
            elif steps.moved:  # further than the tip can have moved: the zero of the displacement has changed
                changes["restarted"] = True
        variance = sample.variance_x_px2
        if not 0.0 <= variance <= self._scene_px**2 and not _missing(variance):
            changes["variance_x_px2"] = self._refuse(Field.VARIANCE)
        captured = sample.captured_s
        if not -_MOST_STAMP_S <= captured <= _MOST_STAMP_S and not _missing(captured):
            changes["captured_s"] = self._refuse(Field.CAPTURED)
        return msgspec.structs.replace(sample, **changes) if changes else sample


def _missing(value: float) -> bool:
    return isinstance(value, float) and isnan(value)  # an integer may be too large to become a float


_PERMISSIONS = (True, False)
_OPERATOR_END = 2 * int(Operator.EMERGENCY_STOP)
