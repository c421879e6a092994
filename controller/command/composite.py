"""Composite control [7]: fast feedback of the oscillation, slow feedback of the image. Derived in docs/damping.md.

Fast, on the estimated deflection and its rate: k (q + q' / b) with the drive's bandwidth b, which puts the closed
loop's poles where an ideal drive would have them. Slow, on the part of the image that is not oscillation: it moves
the joint to where the reference would have led it, as seen by the camera rather than the encoder.
"""

from collections import deque
from math import exp, isfinite, pi

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.beam import tip_slopes_per_m
from stillarm.common.files.model import Model
from stillarm.common.user_error import UserError
from stillarm.controller.estimation.estimate import MOST_UNDATED, Estimate, Status
from stillarm.controller.joint.history import CycleHistory
from stillarm.controller.joint.joint_motion import HISTORY_S, JointMotion

_ZERO_PERIODS = 3.0  # image zero: the mean over the first periods
_JUMP_RAD = 0.02  # from one image to the next: the image zero has changed
_LONGEST_STEP_S = 0.1
_STABLE = 2.0  # gain margin of the slow loop


class CompositeControl:
    """Both parts of the joint velocity, from values that the step provides."""

    def __init__(self, model: Model, length_m: float, gain: float, return_time_s: float) -> None:
        """gain: joint velocity for a deflection, rad/s per metre. return_time_s: time constant of the slow part."""
        mode, camera, cycle_s = model.arm.modes[0], model.camera, model.timing.cycle_s
        late_s = model.timing.capture_delay_s + 1.0 / mode.frequency_hz
        if return_time_s < _STABLE * 2.0 / pi * late_s:
            raise UserError(
                f'controller.damping.return_time_s = {return_time_s:g}: with law = "composite" the image feedback is '
                f"{late_s:.2g} s late, which makes so fast a return unstable; choose at least "
                f"{_STABLE * 2.0 / pi * late_s:.2g}"
            )
        self._gain = gain
        self._return_time_s = return_time_s
        self._lag_s = 1.0 / (2.0 * pi * model.drive.bandwidth_hz)
        self._dead_time_s = model.drive.dead_time_s
        self._stiffness = mode.angular_frequency**2
        self._decay = 2.0 * mode.damping_ratio * mode.angular_frequency
        self._cycle_s = cycle_s
        self._period_s = 1.0 / mode.frequency_hz
        slope = tip_slopes_per_m(length_m, 1)[0]
        px_per_rad = camera.scale_px_per_m * length_m + camera.rotation_px_per_rad
        self._rad_per_px = -1.0 / px_per_rad
        self._rad_per_m = (camera.scale_px_per_m + camera.rotation_px_per_rad * slope) / px_per_rad
        held = int(HISTORY_S / cycle_s) + 2
        self._oscillation = CycleHistory(held)
        self._commanded = CycleHistory(held)
        self._frame = -1
        self._captured_s = 0.0
        self._undated: deque[tuple[VisualSample, float]] = deque(maxlen=MOST_UNDATED)
        self.restart()

    def restart(self) -> None:
        """Forget the image zero, so that it is determined again."""
        self._zero_rad = self._zero_time_s = self._error_rad = 0.0
        self._zeroed = False
        self._seen = 0

    def see_cycle(
        self,
        cycle: int,
        commanded_position_rad: float,
        estimate: Estimate,
        samples: list[VisualSample],
        joint: JointMotion,
    ) -> None:
        """Process a cycle: the joint position by the reference alone, the estimate, and the samples read in it."""
        known = estimate.status in {Status.ESTIMATED, Status.HELD} and isfinite(estimate.deflection_m)
        self._oscillation.write(cycle, estimate.vibration_m if known else 0.0)
        self._commanded.write(cycle, commanded_position_rad)
        self._undated.extend((sample, cycle * self._cycle_s) for sample in samples)
        for sample, read_s, delay_s in self._dated(estimate):
            if known and sample.measured and isfinite(sample.displacement_x_px):
                self._see(sample, read_s - delay_s, joint)

    def _dated(self, estimate: Estimate) -> list[tuple[VisualSample, float, float]]:
        """The images whose delay is now known, with their reading time and delay."""
        if estimate.dated is None:
            ready = [(sample, read_s, estimate.delay.delay_s) for sample, read_s in self._undated]
            self._undated.clear()
            return ready
        return [
            (sample, read_s, delay.delay_s)
            for frame, delay in estimate.dated
            for sample, read_s in self._undated
            if sample.frame == frame
        ]

    def _see(self, sample: VisualSample, captured_s: float, joint: JointMotion) -> None:
        """The slow part of one image: the rest without the oscillation, at its capture instant."""
        at = captured_s / self._cycle_s
        oscillation = self._rad_per_m * self._oscillation.at(at)
        slow = sample.displacement_x_px * self._rad_per_px - oscillation - self._commanded.at(at)
        elapsed = min(max(captured_s - self._captured_s, 0.0), _LONGEST_STEP_S)
        restarted = sample.frame < self._frame
        self._frame, self._captured_s = sample.frame, captured_s
        if restarted:
            self.restart()
        if not self._zeroed:
            off = joint.position_at(captured_s) - self._commanded.at(at)
            self._seen += 1
            self._zero_rad += (slow - off - self._zero_rad) / self._seen
            self._zero_time_s += elapsed if self._seen > 1 else 0.0
            self._zeroed = self._zero_time_s >= _ZERO_PERIODS * self._period_s
            self._error_rad = -off
        elif abs(slow - self._zero_rad + self._error_rad) > _JUMP_RAD:
            self.restart()
        else:
            gain = 1.0 - exp(-elapsed / self._period_s)
            self._error_rad += gain * (self._zero_rad - slow - self._error_rad)

    def velocity_rad_s(self, estimate: Estimate, joint_error_rad: float) -> float:
        """Sum of the fast and slow part. joint_error_rad, by the encoder, stands in until the image zero is known."""
        q, v = estimate.vibration_m, estimate.deflection_rate_m_s
        bend = -self._stiffness * q - self._decay * v
        ahead = self._dead_time_s
        q, v = q + ahead * v + 0.5 * ahead * ahead * bend, v + ahead * bend
        slow = self._error_rad if self._zeroed else joint_error_rad
        return self._gain * (q + self._lag_s * v) + slow / self._return_time_s
