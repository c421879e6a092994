"""The quantities of a recording's simulation: names, bounds, steps, where they begin, what a baseline refits."""

from dataclasses import dataclass, replace
from math import pi

import numpy as np

from stillarm.common.files.model import Model
from stillarm.diagnosis.data.frame_clock import FrameClock
from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.physics.declared_effects import declared_quantities, own_quantities, waves_to_refit
from stillarm.diagnosis.physics.space import Quantity, Space

_NEVER_S = 1e9  # an onset at 30 years: after any recording's end
UNLIMITED = 1e9
"""A limit, in its unit, that no rig reaches: the largest number that a model file takes."""
HIGHER = "arm.higher_modes_share"  # of a change of the first mode's frequency, what the others' takes
ARRIVAL = "drive.arrival_s"  # by which commands come later than the dead time says: a part of a cycle
_ARRIVAL, _ARRIVAL_STD = 0.1, 0.05  # cycles: what no drive keeps, nor an integrator with a step of a tenth
RANGE = "accelerometer.range_m_s2"
MOST_UP, MOST_DOWN = "accelerometer.most_up_m_s2", "accelerometer.most_down_m_s2"
"""Limits of one side of the reading, beside the range of both."""
SPEEDING, SLOWING = "drive.lag_speeding_up_s", "drive.lag_slowing_down_s"
LAG_BEND = "accelerometer.lag_bend"
"""Of a sensor's filter 1 / (1 + lag s + bend (lag s)^2): 0 is of first order, 1/4 two equal lags, 1/2 Butterworth's."""
GRAVITY_SINE, GRAVITY_COSINE = "accelerometer.gravity_sine_m_s2", "accelerometer.gravity_cosine_m_s2"
"""What the sensor feels of gravity, by the sine of its angle and by its cosine less one."""
GRAVITY_SLOPE = (
    "accelerometer.gravity_of_slope"  # share of the tip's slope by which the sensor turns beside the joint
)
OF_ARRIVALS = "accelerometer.of_arrivals"  # share of a jump that a command brings as the sensor is read
OF_LAST_JUMP = "accelerometer.of_last_jump"  # share of a command's jump, beyond what interpolation has of it
_OF_LAST_JUMP_STD = 0.5  # where within a cycle a late sensor reads, and how sharply, is unknown
DRIVE_BEGIN, ARM_BEGIN = "drive.begin_s", "arm.begin_s"  # from when on what departs from the model acts there
COASTING = (
    "drive.coasting_gap_rad",
    "drive.coasting_drag_per_s",
    "drive.teeth_hz",
    "drive.teeth_damping",
)
"""Of a play behind which the link coasts (stillarm.diagnosis.physics.coasting_play)."""
ACCELEROMETER_BEGIN, CAMERA_BEGIN = "accelerometer.begin_s", "camera.begin_s"
SKEW_BEGIN = "timing.skew_begin_s"
SKEW = "timing.skew_ppm"
QUARTZ, _QUARTZ_PPM = "timing.quartz_ppm", 20.0
"""By how much two sound clocks differ: crystals are sold to 20 ppm, and a clock within that has nothing wrong."""
_LOCKING_PX = 0.015  # the most by which a good tracker strays with the place in the pixel


@dataclass(frozen=True)
class Layout:
    """What there is to simulate. modes: bending modes, the model's and more. jumps: of the state, the start's among
    them. length_m: of the arm; zero for a pair. channels: those that were measured."""

    measured: Measured
    model: Model
    modes: int
    jumps: int
    length_m: float
    clock: FrameClock
    channels: frozenset[str]

    def space(self) -> Space:
        """All of them, with what the model and the data say of each at the start."""
        model, space, measured = self.model, Space(), self.measured
        joint = measured.position[np.isfinite(measured.position)]
        swift = measured.velocity[np.isfinite(measured.velocity)]
        space.add(Quantity("start.theta", float(joint[0]) if len(joint) else 0.0, step=1e-5, prior_std=1.0))
        space.add(Quantity("start.omega", float(swift[0]) if len(swift) else 0.0, step=1e-4, prior_std=0.5))
        scale = float(np.nanstd(measured.deflection)) if measured.pair else 0.01
        scale = scale or 0.01
        for i in range(self.modes):
            known = i < len(model.arm.modes)
            mode = model.arm.modes[i] if known else None
            f = mode.frequency_hz if mode else 50.0
            z = mode.damping_ratio if mode else 0.01
            p = mode.participation if mode else 0.0
            top = 0.49 / measured.cycle_s
            space.add(
                Quantity(f"modes.{i}.frequency_hz", f, 0.02, top, 1e-5 * f, 0.3 * f if mode else np.inf)
            )
            space.add(Quantity(f"modes.{i}.damping_ratio", z, 0.0, 0.9, 1e-5, max(0.05, 5 * z)))
            space.add(Quantity(f"modes.{i}.participation", p, -50.0, 50.0, 1e-4, 2.0))
            w = 2 * pi * f
            for j in range(self.jumps):
                space.add(Quantity(f"jump.{j}.{i}.q", 0.0, step=1e-3 * scale, prior_std=30 * scale))
                space.add(Quantity(f"jump.{j}.{i}.v", 0.0, step=1e-3 * w * scale, prior_std=30 * w * scale))
        drive, sensor, camera, timing = model.drive, model.accelerometer, model.camera, model.timing
        for name, start, low, high, step in (
            ("drive.bandwidth_hz", drive.bandwidth_hz, 0.1, 2000.0, 1e-3 * drive.bandwidth_hz),
            ("drive.dead_time_s", drive.dead_time_s, 0.0, 1.0, 1e-5),
            (ARRIVAL, 0.0, -_ARRIVAL * measured.cycle_s, _ARRIVAL * measured.cycle_s, 0.01 * measured.cycle_s),
            ("drive.max_velocity_rad_s", drive.max_velocity_rad_s, 1e-4, UNLIMITED, 1e-4),
            ("drive.deadband_rad_s", 0.0, 0.0, 10.0, 1e-4),
            ("drive.velocity_loss_rad_s", 0.0, 0.0, 10.0, 1e-5),
            ("drive.gap_rad", 0.0, 0.0, 1.0, 1e-5),
            (COASTING[0], 0.0, 0.0, 1.0, 1e-6),
            (COASTING[1], 1.0, 0.0, 1e4, 1e-3),
            (COASTING[2], 60.0, 1.0, 300.0, 1e-2),
            (COASTING[3], 0.3, 0.0, 2.0, 1e-4),
            (DRIVE_BEGIN, 0.0, 0.0, _NEVER_S, measured.cycle_s),
            ("drive.further_dead_time_s", 0.0, 0.0, 1.0, 1e-5),
            ("drive.further_lag_s", 0.0, 0.0, 2.0, 1e-5),
            ("drive.friction_rad_s", 0.0, 0.0, 10.0, 1e-5),
            ("drive.static_friction_rad_s", 0.0, 0.0, 10.0, 1e-5),
            ("drive.friction_one_sided", 0.0, -1.0, 1.0, 1e-3),
            ("drive.most_rad_s2", UNLIMITED, 1e-3, UNLIMITED, 1e-3),
            ("drive.most_up_rad_s2", UNLIMITED, 1e-3, UNLIMITED, 1e-3),
            ("drive.most_down_rad_s2", UNLIMITED, 1e-3, UNLIMITED, 1e-3),
            ("drive.fastest_up_rad_s", UNLIMITED, 1e-4, UNLIMITED, 1e-4),
            ("drive.fastest_down_rad_s", UNLIMITED, 1e-4, UNLIMITED, 1e-4),
            (SPEEDING, 0.0, 0.0, 2.0, 1e-5),
            (SLOWING, 0.0, 0.0, 2.0, 1e-5),
            (ARM_BEGIN, 0.0, 0.0, _NEVER_S, measured.cycle_s),
            (ACCELEROMETER_BEGIN, 0.0, 0.0, _NEVER_S, measured.cycle_s),
            (CAMERA_BEGIN, 0.0, 0.0, _NEVER_S, measured.cycle_s),
            ("arm.coulomb_m_s2", 0.0, 0.0, 1e3, 1e-5),
            ("arm.quadratic_per_m", 0.0, -1e6, 1e6, 1e-4),
            ("arm.cubic_per_m2", 0.0, -1e9, 1e9, 1e-2),
            ("arm.onset_s", _NEVER_S, 0.0, _NEVER_S, measured.cycle_s),
            ("arm.frequency_ratio", 1.0, 0.2, 5.0, 1e-5),
            ("arm.frequency_rate_per_s", 0.0, -0.2, 0.2, 1e-7),
            (HIGHER, 1.0, -10.0, 10.0, 1e-3),
            ("arm.periodic_hz", 0.0, 0.0, 500.0, 1e-5),
            ("arm.periodic_sin", 0.0, -1e4, 1e4, 1e-5),
            ("arm.periodic_cos", 0.0, -1e4, 1e4, 1e-5),
            ("accelerometer.scale", sensor.scale, -1e6, 1e6, 1e-4),
            ("accelerometer.bias_m_s2", sensor.bias_m_s2, -1e3, 1e3, 1e-4),
            ("accelerometer.rate_m_s3", 0.0, -1e3, 1e3, 1e-5),
            ("accelerometer.rate_per_s", 0.0, -1.0, 1.0, 1e-6),
            (RANGE, sensor.range_m_s2, 1e-3, UNLIMITED, 1e-3),
            (MOST_UP, UNLIMITED, 1e-3, UNLIMITED, 1e-3),
            (MOST_DOWN, UNLIMITED, 1e-3, UNLIMITED, 1e-3),
            ("accelerometer.delay_s", sensor.delay_s, 0.0, 0.2, 1e-5),
            ("accelerometer.lag_s", 0.0, 0.0, 0.5, 1e-5),
            (LAG_BEND, 0.0, 0.0, 1.0, 1e-3),
            (OF_ARRIVALS, 0.0, -0.5, 1.5, 1e-3),
            (OF_LAST_JUMP, 0.0, -1.0, 1.0, 1e-3),
            ("accelerometer.gravity_m_s2_per_rad", 0.0, -50.0, 50.0, 1e-4),
            (GRAVITY_SINE, 0.0, -50.0, 50.0, 1e-4),
            (GRAVITY_COSINE, 0.0, -50.0, 50.0, 1e-4),
            (GRAVITY_SLOPE, 1.0, -0.5, 2.0, 1e-3),
            ("accelerometer.hum_hz", 0.0, 0.0, 5000.0, 1e-5),
            ("accelerometer.hum_sin", 0.0, -1e3, 1e3, 1e-5),
            ("accelerometer.hum_cos", 0.0, -1e3, 1e3, 1e-5),
            ("accelerometer.hum_third_sin", 0.0, -1e3, 1e3, 1e-5),
            ("accelerometer.hum_third_cos", 0.0, -1e3, 1e3, 1e-5),
            ("camera.scale_px_per_m", camera.scale_px_per_m, -1e7, 1e7, 1e-5 * abs(camera.scale_px_per_m)),
            ("camera.offset_px", 0.0, -1e6, 1e6, 1e-3),
            ("camera.rotation_px_per_rad", camera.rotation_px_per_rad, -1e7, 1e7, 1e-2),
            ("camera.rate_px_per_s", 0.0, -1e4, 1e4, 1e-4),
            ("camera.lens_per_px2", 0.0, -0.1, 0.1, 1e-9),
            ("camera.locking_sin_px", 0.0, -_LOCKING_PX, _LOCKING_PX, 1e-4),
            ("camera.locking_cos_px", 0.0, -_LOCKING_PX, _LOCKING_PX, 1e-4),
            ("timing.capture_delay_s", timing.capture_delay_s, -0.5, 3.0, 1e-5),
            ("timing.arrival_s", 0.0, -1e4, 1e4, 1e-5),
            (SKEW, 0.0, -1e4, 1e4, 0.1),
            (SKEW_BEGIN, 0.0, 0.0, _NEVER_S, measured.cycle_s),
            (QUARTZ, 0.0, -_QUARTZ_PPM, _QUARTZ_PPM, 0.1),
            ("timing.delay_rate", 0.0, -0.1, 0.1, 1e-7),
            ("timing.stale_onset_s", _NEVER_S, 0.0, _NEVER_S, measured.cycle_s),
            ("timing.stale_frames", 0.0, -8.0, 8.0, 1e-3),
            ("timing.step_onset_s", _NEVER_S, 0.0, _NEVER_S, measured.cycle_s),
            ("timing.step_s", 0.0, -10.0, 10.0, 1e-5),
            ("pair.gain", 1.0, -1e12, 1e12, 1e-3),
            ("pair.offset", 0.0, -1e9, 1e9, 1e-6),
            ("pair.input_offset", 0.0, -1e9, 1e9, 1e-6),
        ):  # fmt: skip
            space.add(Quantity(name, start, low, high, step))
        for one in own_quantities():
            space.add(one)
        return self._with_starts(space)

    def _with_starts(self, space: Space) -> Space:
        """Start values that the data give at once: image zero, mean arrival, a pair's gain."""
        measured, frames = self.measured, self.measured.frames
        sets: dict[str, tuple[float, float]] = {
            "timing.capture_delay_s": (self.model.timing.capture_delay_s, 0.3)
        }
        sets["camera.scale_px_per_m"] = (
            self.model.camera.scale_px_per_m,
            2.0 * abs(self.model.camera.scale_px_per_m),
        )
        sets[QUARTZ] = (0.0, 0.5 * _QUARTZ_PPM)
        sets[OF_ARRIVALS] = (0.0, 1.0)
        sets[OF_LAST_JUMP] = (0.0, _OF_LAST_JUMP_STD)
        sets[ARRIVAL] = (0.0, _ARRIVAL_STD * measured.cycle_s)
        sets["accelerometer.bias_m_s2"] = (self.model.accelerometer.bias_m_s2, 10.0)
        if "displacement" in self.channels:
            seen = frames.displacement_px[np.isfinite(frames.displacement_px)]
            theta = space["start.theta"].start
            sets["camera.offset_px"] = (
                float(np.median(seen)) + self.model.camera.scale_px_per_m * self.length_m * theta, 1e4,
            )  # fmt: skip
        if "arrival" in self.channels:
            late = frames.received_s - self.clock.grid_s
            sets["timing.arrival_s"] = (float(np.nanmedian(late)), 1.0)
        if measured.pair:
            w = 2 * pi * self.model.arm.modes[0].frequency_hz
            out = float(np.nanstd(measured.deflection))
            sets["pair.gain"] = (w * w * out / (float(np.std(measured.force)) or 1.0), np.inf)
            sets["pair.offset"] = (float(np.nanmean(measured.deflection)), out)
            sets["pair.input_offset"] = (0.0, float(np.std(measured.force)))
        for name, value in declared_quantities(self.model).items():
            space.quantities[space.place[name]] = replace(space[name], start=value)
        for name, (start, std) in sets.items():
            at = space.place[name]
            old = space.quantities[at]
            step = old.step if name != "pair.gain" else 1e-4 * abs(start)
            step = step if name != "pair.offset" else 1e-4 * float(np.nanstd(measured.deflection))
            step = step if name != "pair.input_offset" else 1e-4 * std
            space.quantities[at] = replace(old, start=start, step=step, prior_std=std)
        return space

    def baseline_names(self) -> list[str]:
        """What the baseline refits (the contract's list), as far as this recording's channels can show it."""
        has = self.channels
        names: list[str] = []
        for i in range(len(self.model.arm.modes)):
            names += [f"modes.{i}.frequency_hz", f"modes.{i}.damping_ratio"]
            if not self.measured.pair:
                names.append(f"modes.{i}.participation")
            for j in range(self.jumps):
                names += [f"jump.{j}.{i}.q", f"jump.{j}.{i}.v"]
        if self.measured.pair:
            return [*names, "pair.gain", "pair.offset", "pair.input_offset"]
        if "joint_position" in has:
            names.append("start.theta")
        if "joint_velocity" in has or "joint_position" in has:
            names.append("start.omega")
        names += waves_to_refit(self.model)
        if "acceleration" in has:
            names += ["accelerometer.bias_m_s2", OF_ARRIVALS]
        if has & {"acceleration", "joint_position", "joint_velocity"}:
            names.append(ARRIVAL)
        if "displacement" in has:
            names += ["camera.scale_px_per_m", "camera.offset_px", "timing.capture_delay_s"]
            if self.measured.has_fine_image:
                names += ["camera.locking_sin_px", "camera.locking_cos_px"]
        if "arrival" in has:
            names.append("timing.arrival_s")
        if has >= {"displacement", "arrival"} and self.clock.counted:
            names.append(QUARTZ)
        return names
