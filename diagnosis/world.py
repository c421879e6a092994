"""From the vector to what each channel should have shown: the simulation of a recording, in free run.

Channels: acceleration, joint_position, joint_velocity, deflection (on the controller's grid); displacement (per frame);
arrival (per frame: when it was read, less when it was exposed).
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from stillarm.common.causes import CAUSES
from stillarm.common.causes.declaration import Acts
from stillarm.common.files.beam import tip_slopes_per_m
from stillarm.common.files.effects import filled_in
from stillarm.common.files.model import Model
from stillarm.diagnosis.added import Added
from stillarm.diagnosis.budget import check_time
from stillarm.diagnosis.channels import FRAME_CHANNELS, present_channels
from stillarm.diagnosis.declared_effects import effects_in, is_behind_encoder
from stillarm.diagnosis.exposure import expose
from stillarm.diagnosis.fine_sensors import tip_moved, within_reach
from stillarm.diagnosis.frame_clock import FrameClock, frame_clock
from stillarm.diagnosis.kernel import add_decay, free_decay, tip_of
from stillarm.diagnosis.measured import Measured
from stillarm.diagnosis.measured_joint import answer_to_joint, smoothed
from stillarm.diagnosis.quantities import (
    ACCELEROMETER_BEGIN,
    ARM_BEGIN,
    ARRIVAL,
    CAMERA_BEGIN,
    DRIVE_BEGIN,
    OF_ARRIVALS,
    OF_LAST_JUMP,
    RANGE,
    Layout,
)
from stillarm.diagnosis.space import Quantity
from stillarm.diagnosis.struck_flanks import without_strikes
from stillarm.diagnosis.velocity_loop import equivalent_command
from stillarm.simulation.arm.compiled_laws import laws_of, obeyed
from stillarm.simulation.arm.free_run import driven_run, free_run, reads_later
from stillarm.simulation.arm.state import make_arm

Array = NDArray[np.float64]

_TIE_S, _JUST_S = 2e-7, 1e-7  # between frames read at once; less than that
_DECAYS = 4  # remembered
_SEEN_ONLY = ("accelerometer.", "camera.", "timing.", "pair.offset")  # quantities that move nothing
_GRANTED = 0.9
_STROKE_S = 0.02  # to either side of an impact: a soft hammer's lasts 5 to 20 ms
_ABOUT_EXPOSED_S = 0.02  # by which an image's instant is uncertain
_OF_THE_LOOP = (
    "drive.further_dead_time_s",
    "drive.further_lag_s",
    "drive.friction_rad_s",
    "drive.static_friction_rad_s",
    "drive.friction_one_sided",
    "drive.most_rad_s2",
    "drive.most_up_rad_s2",
    "drive.most_down_rad_s2",
    "drive.fastest_up_rad_s",
    "drive.fastest_down_rad_s",
)
_OF_TIME = ("periodic_disturbance",)  # forces that ask for no state: a linear mode stays one
_TURN = 0.03  # rad of the first mode in a step of its laws: to 1e-7 of the amplitude
_TURN_OF_PAIR = 0.25  # to 1e-4: a pair has few samples a period
_SUBSTEPS_OF_PAIR = 2


@dataclass(frozen=True)
class Motion:
    """What the arm did: arrays over the grid. tip: s, m; tip_acceleration: s'', m/s^2; slope: tip angle, rad."""

    joint: Array
    motor: Array
    q: Array
    deflection: Array
    tip: Array
    tip_acceleration: Array
    tip_angle: Array
    of: Array
    """Values of the quantities that it follows from."""


@dataclass(frozen=True)
class Predicted:
    """What each channel should show, by name, and displacement's rate at the frames, px/s (for doubt of instants)."""

    channels: dict[str, Array]
    rate_px_s: Array
    motion: Motion


class World:
    """A recording's inputs and the model's structure; `predict` is a pure function of the vector.

    modes: bending modes, the model's and `extra_modes` more. impacts: cycles at which an impact opens a new segment.
    """

    def __init__(
        self,
        measured: Measured,
        model: Model,
        impacts: tuple[int, ...] = (),
        extra_modes: int = 0,
        behind_encoder: bool = False,
        clock: FrameClock | None = None,
        added: tuple[Added, ...] = (),
        unjudged_s: tuple[tuple[float, float], ...] = (),
        joint_hz: float = 0.0,
        strokes: tuple[int, ...] | None = None,
    ) -> None:
        """Lay out the vector. behind_encoder: a play lies behind the joint sensor. clock: the frames', if known.
        added: terms without a formula. unjudged_s: spans in which something unknown holds the arm, from and to.
        joint_hz: up to which frequency the arm is moved by the joint as it was measured. strokes: cycles about which
        the accelerometer is not judged; those of the impacts, if not given."""
        self.strokes = impacts if strokes is None else strokes
        self.added, self.unjudged_s, self.joint_hz = added, unjudged_s, joint_hz
        self._departures: list[tuple[bytes, Array, Array]] = []
        self.measured, self.model = measured, model
        self.impacts, self.extra_modes = impacts, extra_modes
        self.behind_encoder = behind_encoder or is_behind_encoder(model)
        self.frame_clock: FrameClock = clock or frame_clock(measured.frames, model)
        # a clock that is set back makes frames seem to come before those before them
        received = measured.frames.received_s
        self.in_order_s = np.maximum.accumulate(received) + _TIE_S * np.arange(len(received))
        self.modes = len(model.arm.modes) + extra_modes
        self.length = 0.0 if measured.pair else (model.arm.length_m or 1.0)
        self._slopes = np.array(tip_slopes_per_m(self.length or 1.0, self.modes))
        self._force = _upsampled(measured.force, 2 * _SUBSTEPS_OF_PAIR) if measured.pair else np.empty(0)
        self._jump_cycles = np.array([0, *impacts], dtype=np.int64)
        self._command = np.nan_to_num(measured.command)
        self.cycle_times: Array = np.arange(measured.cycles, dtype=np.float64) * measured.cycle_s
        self._aged = bool(np.any(measured.joint_age_s > 0.05 * measured.cycle_s))
        present = present_channels(measured, self.frame_clock)
        self.channels, self.channels_left_out = present.values, present.left_out
        for span in unjudged_s:
            self._leave_out(span)
        self._leave_out_strokes()
        self._layout = Layout(
            measured, model, self.modes, len(self._jump_cycles), self.length, self.frame_clock,
            frozenset(self.channels),
        )  # fmt: skip
        self.space = self._layout.space()
        for group in added:
            for name in group.amounts:
                self.space.add(Quantity(name, 0.0, step=1e-3 * group.prior_std, prior_std=group.prior_std))
        self._jumps = {
            self.space.place[f"jump.{j}.{i}.{part}"]: (int(cycle), i, part == "v")
            for j, cycle in enumerate(self._jump_cycles)
            for i in range(self.modes)
            for part in "qv"
        }
        none = np.empty(0)
        self._joint_seen: tuple[Array, Array, Array] = (none, none, none)  # of the last joint and modes
        self._decays: dict[tuple[float, float], Array] = {}
        self._usual = self.space.vector()
        kept = ("accelerometer.bias_m_s2", ACCELEROMETER_BEGIN, OF_ARRIVALS)  # the baseline's, or no effect
        self._of_sensor = [
            place
            for name, place in self.space.place.items()
            if name.startswith("accelerometer.") and name not in kept
        ]
        self._moving = np.array(
            [
                at
                for name, at in self.space.place.items()
                if not name.startswith((*_SEEN_ONLY, *(f"{one.name}." for one in self.added)))
            ]
        )

    def changed(
        self,
        impacts: tuple[int, ...] | None = None,
        extra_modes: int | None = None,
        behind_encoder: bool | None = None,
        added: tuple[Added, ...] | None = None,
        unjudged_s: tuple[tuple[float, float], ...] | None = None,
        joint_hz: float | None = None,
        strokes: tuple[int, ...] | None = None,
    ) -> "World":
        """The same recording and model in a world of another structure; what is not given stays. The frames' clock,
        which a search works out, is the same."""
        return World(
            self.measured,
            self.model,
            self.impacts if impacts is None else impacts,
            self.extra_modes if extra_modes is None else extra_modes,
            self.behind_encoder if behind_encoder is None else behind_encoder,
            self.frame_clock,
            self.added if added is None else added,
            self.unjudged_s if unjudged_s is None else unjudged_s,
            self.joint_hz if joint_hz is None else joint_hz,
            strokes if strokes is not None or impacts is not None else self.strokes,
        )

    def with_measured(self, measured: Measured, impacts: tuple[int, ...] | None = None) -> "World":
        """Other data, or the same dated otherwise, in a world of the same structure."""
        return World(
            measured, self.model, self.impacts if impacts is None else impacts, self.extra_modes,
            self.behind_encoder, None, self.added, self.unjudged_s, self.joint_hz,
        )  # fmt: skip

    def _leave_out(self, span_s: tuple[float, float]) -> None:
        """Take what the arm shows in a span for unmeasured."""
        start, end = span_s
        received, delay = self.measured.frames.received_s, self.model.timing.capture_delay_s
        exposed = received - delay
        inside = {
            "acceleration": (self.cycle_times >= start) & (self.cycle_times < end),
            "displacement": (exposed >= start - _ABOUT_EXPOSED_S) & (exposed < end + _ABOUT_EXPOSED_S),
        }
        inside["deflection"] = inside["acceleration"]
        for name, mask in inside.items():
            if name in self.channels:
                self.channels[name] = np.where(mask, np.nan, self.channels[name])

    def _leave_out_strokes(self) -> None:
        """Take what the accelerometer shows of an impact itself for unmeasured: it lasts some milliseconds, of a course
        that nothing tells, and the sensor at the tip sees the force."""
        shown = self.channels.get("acceleration")
        if shown is None or not self.strokes:
            return
        shown, reach = shown.copy(), max(1, round(_STROKE_S / self.measured.cycle_s))
        for cycle in self.strokes:
            shown[max(cycle - reach, 0) : cycle + reach] = np.nan
        self.channels["acceleration"] = shown

    def added_group(self, name: str) -> Added | None:
        """The added terms of that name; None where there are none."""
        return next((one for one in self.added if one.name == name), None)

    def slopes_of_amount(self, name: str) -> dict[str, Array] | None:
        """Derivative of each channel by an added term's amount, (samples,); None for any other quantity."""
        group, _, number = name.rpartition(".")
        found = self.added_group(group)
        return None if found is None else {one: by[:, int(number)] for one, by in found.columns.items()}

    def baseline_names(self) -> list[str]:
        """What the baseline refits (the contract's list), as far as this recording's channels can show it."""
        return self._layout.baseline_names()

    def step_s(self, channel: str) -> float:
        """Time between a channel's samples, s."""
        return 1.0 / self.model.camera.frame_rate_hz if channel in FRAME_CHANNELS else self.measured.cycle_s

    def just_before(self, frames: int | NDArray[np.bool_]) -> Array:
        """Instants just before those frames, by place or mask, were read, s: an onset there counts for them."""
        return np.asarray(self.in_order_s[frames] - _JUST_S)

    def move(self, vector: Array) -> Motion:
        """The arm's motion under the recorded inputs. Raises OutOfTime within a limit that has passed."""
        check_time()
        at, n, m = self.space.place, self.measured.cycles, self.modes
        rows = np.empty((m, 3))
        jumps = np.empty((len(self._jump_cycles), m, 2))
        for i in range(m):
            first = at[f"modes.{i}.frequency_hz"]
            rows[i] = vector[first : first + 3]
            count = len(self._jump_cycles)
            jumps[:, i, :] = vector[first + 3 : first + 3 + 2 * count].reshape(count, 2)
        rows[:, 2] *= self.length
        effects = effects_in(vector, at)
        drive = msgspec.structs.replace(
            self.model.drive,
            bandwidth_hz=float(vector[at["drive.bandwidth_hz"]]),
            dead_time_s=self._dead_s(vector),
        )
        turn = _TURN_OF_PAIR if self.measured.pair else _TURN
        gap = float(vector[at["drive.gap_rad"]])
        laws = laws_of(effects, float(vector[at[ARM_BEGIN]]))
        arm, whole = make_arm(drive, self.measured.cycle_s, rows, laws, gap, turn)
        arm["motor"], arm["rate"] = vector[at["start.theta"]], vector[at["start.omega"]]
        joint, motor = np.zeros((n, 4)), np.zeros((n, 2))
        q, qdd = np.empty((n, m)), np.empty((n, m))
        if self.measured.pair:
            force = vector[at["pair.gain"]] * (self._force + vector[at["pair.input_offset"]])
            driven_run(arm, force, self.measured.cycle_s, _SUBSTEPS_OF_PAIR, self._jump_cycles, jumps, q, qdd)
        else:
            command = self._obeyed(vector, effects)
            free_run(arm, command, whole, self._jump_cycles, jumps, joint, motor, q, qdd)
        deflection, tip, tip_acceleration, tip_angle = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
        seen = self._as_measured(joint, motor, rows, q, qdd) if self.joint_hz > 0.0 else joint
        tip_of(seen, q, qdd, self.length, self._slopes, deflection, tip, tip_acceleration, tip_angle)
        of = vector[self._moving]
        return Motion(joint, motor, q, deflection, tip, tip_acceleration, tip_angle, of)

    def _as_measured(self, joint: Array, motor: Array, rows: Array, q: Array, qdd: Array) -> Array:
        """The joint's motion with what was measured of it; moves the modes with that, in place."""
        reported = (motor if self.behind_encoder else joint)[:, 0]
        key = reported.tobytes()
        known = next((one for one in self._departures if one[0] == key), None)
        if known is None:
            off = self.measured.position - self._aged_to_reading(reported)
            known = (key, *smoothed(off, self.joint_hz, self.measured.cycle_s))
            self._departures = [*self._departures[-_DECAYS + 1 :], known]
        _, slow, second = known
        for i, (hz, damping, push) in enumerate(rows):
            more, more_second = answer_to_joint(second, hz, damping, push, self.measured.cycle_s)
            q[:, i] += more
            qdd[:, i] += more_second
        moved = joint.copy()
        moved[:, 0] += slow
        moved[:, 2] += second
        return moved

    def _aged_to_reading(self, value: Array) -> Array:
        if not self._aged:
            return value
        return np.interp(self.cycle_times - self.measured.joint_age_s, self.cycle_times, value)

    def _obeyed(self, vector: Array, effects: list[tuple[str, dict[str, float]]]) -> Array:
        """The commands that a plain drive would have to obey to move as this one does, rad/s."""
        at = self.space.place
        limit = self.model.drive.max_velocity_rad_s
        plain = np.clip(self._command, -limit, limit)
        limit = vector[at["drive.max_velocity_rad_s"]]
        command = obeyed(effects, np.clip(self._command, -limit, limit))
        begin_s = vector[at[DRIVE_BEGIN]]
        if begin_s > 0.0:
            command = np.where(self.cycle_times >= begin_s, command, plain)
        own = [float(vector[at[name]]) for name in _OF_THE_LOOP]
        if own == [self.space[name].start for name in _OF_THE_LOOP]:
            return command
        decay = 2.0 * pi * float(vector[at["drive.bandwidth_hz"]])
        omega = float(vector[at["start.omega"]])
        found: Array = equivalent_command(command, self.measured.cycle_s, decay, omega, float(begin_s), *own)
        return found

    def _dead_s(self, vector: Array) -> float:
        """When a command arrives at the drive, s after its cycle began."""
        at = self.space.place
        return max(0.0, float(vector[at["drive.dead_time_s"]] + vector[at[ARRIVAL]]))

    def predict(self, vector: Array, near: Predicted | None = None) -> Predicted:
        """All channels that were measured. near: its motion is taken where the vector says the same of it."""
        at = self.space.place
        motion = self._moved(vector, near.motion) if near is not None else self.move(vector)
        found: dict[str, Array] = {}
        rate = np.empty(0)
        same_joint = near is not None and motion.joint is near.motion.joint
        for which, name in enumerate(("joint_position", "joint_velocity")):
            if name in self.channels:
                found[name] = near.channels[name] if near and same_joint else self._seen_joint(motion, which)
        if "deflection" in self.channels:
            found["deflection"] = motion.deflection + vector[at["pair.offset"]]
        if "acceleration" in self.channels:
            found["acceleration"] = self._acceleration(motion, vector)
        if "displacement" in self.channels:
            found["displacement"], rate = self._displacement(motion, vector)
        if "arrival" in self.channels:
            found["arrival"] = self._arrivals(vector)
        for group in self.added:
            amounts = vector[[at[name] for name in group.amounts]]
            if amounts.any():
                for name, columns in group.columns.items():
                    if name in found:
                        found[name] = found[name] + columns @ amounts
        return Predicted(found, rate, motion)

    def residual(self, name: str, predicted: Predicted, vector: Array) -> Array:
        """A channel's measured values less those predicted, as the data are judged by."""
        off: Array = self.channels[name] - predicted.channels[name]
        if name != "acceleration" or vector[self.space.place["drive.gap_rad"]] == 0.0:
            return off
        omega, noise = predicted.motion.joint[:, 1], self.measured.fast_noise_m_s2
        return without_strikes(off, omega, self.length, noise, self.measured.cycle_s)

    def _moved(self, vector: Array, near: Motion) -> Motion:
        """The arm's motion, from one nearby where nothing differs but what jumps: a linear mode's answer adds up."""
        differ = self._moving[vector[self._moving] != near.of]
        if not len(differ):
            return near
        jumps = [self._jumps.get(int(place)) for place in differ]
        if None in jumps or not self._answers_linearly(vector, {one[1] for one in jumps if one is not None}):
            return self.move(vector)
        q, deflection, tip = near.q.copy(), near.deflection.copy(), near.tip.copy()
        tip_acceleration, tip_angle = near.tip_acceleration.copy(), near.tip_angle.copy()
        was = dict(zip(self._moving.tolist(), near.of.tolist(), strict=True))
        for place, one in zip(differ.tolist(), jumps, strict=True):
            assert one is not None
            cycle, mode, velocity = one
            amount = float(vector[place]) - was[place]
            add_decay(
                self._decay(vector, mode), cycle, 0.0 if velocity else amount, amount if velocity else 0.0,
                self._slopes[mode], q[:, mode], deflection, tip, tip_acceleration, tip_angle,
            )  # fmt: skip
        of = vector[self._moving]
        return Motion(near.joint, near.motor, q, deflection, tip, tip_acceleration, tip_angle, of)

    def _answers_linearly(self, vector: Array, modes: set[int]) -> bool:
        """Whether these modes keep their frequency, and answer a jump whatever else they do."""
        acting = {
            CAUSES[cause].acts for cause, _ in effects_in(vector, self.space.place) if cause not in _OF_TIME
        }
        return "frequency" not in acting and (0 not in modes or not acting & {"force", "friction"})

    def _decay(self, vector: Array, mode: int) -> Array:
        """What a jump of a mode does from then on; the last few are remembered."""
        first = self.space.place[f"modes.{mode}.frequency_hz"]
        key = (float(vector[first]), float(vector[first + 1]))
        known = self._decays.get(key)
        if known is None:
            known = np.empty((self.measured.cycles, 4))
            free_decay(*key, self.measured.cycle_s, known)
            if len(self._decays) >= _DECAYS:
                self._decays.clear()
            self._decays[key] = known
        return known

    def _reported(self, motion: Motion, which: int) -> Array:
        """Joint position (0) or velocity (1) as the drive reports it, joint_age_s old."""
        return self._aged_to_reading((motion.motor if self.behind_encoder else motion.joint)[:, which])

    def reported_position(self, vector: Array) -> Array:
        """The joint's position as the drive would report it, rad, whether it was measured or not."""
        return self._seen_joint(self.move(vector), 0)

    def _seen_joint(self, motion: Motion, which: int) -> Array:
        """The same as the data are judged by. To a fine encoder what a simulated drive may be off is no noise, of which
        many samples would make a discovery: most of it is granted, and the rest tells a fit the way."""
        granted = which == 0 and self.measured.has_fine_encoder and self.joint_hz == 0.0
        return self._reported(motion, which) + (_GRANTED * self._off(motion) if granted else 0.0)

    def _off(self, motion: Motion) -> Array:
        """By how much a fine encoder saw the joint elsewhere, rad, as far as a simulated drive may be off."""
        return within_reach(self.measured.position, self._reported(motion, 0))

    def _acceleration(self, motion: Motion, vector: Array) -> Array:
        at = self.space.place
        begin_s = vector[at[ACCELEROMETER_BEGIN]]
        if begin_s <= 0.0:
            return self._read(motion, vector)
        usual = vector.copy()
        usual[self._of_sensor] = self._usual[self._of_sensor]
        return np.where(self.cycle_times >= begin_s, self._read(motion, vector), self._read(motion, usual))

    def _read(self, motion: Motion, vector: Array) -> Array:
        """What the accelerometer reads, m/s^2."""
        at = self.space.place
        t = np.maximum(self.cycle_times - vector[at[ACCELEROMETER_BEGIN]], 0.0)
        value = motion.tip_acceleration + self._of_arrivals(motion, vector)
        cycles = vector[at["accelerometer.delay_s"]] / self.measured.cycle_s
        if cycles > 0.0:
            value = _late(value, cycles)
        if vector[at[OF_LAST_JUMP]]:
            value = value + self._of_last_jump(motion, vector, int(cycles))
        lag_s = vector[at["accelerometer.lag_s"]]
        if lag_s > 0.0:
            value = _lagged(value, self.measured.cycle_s / lag_s)
        gain = vector[at["accelerometer.scale"]]
        effects = effects_in(vector, at)
        for law in _laws_at(effects, "sensitivity"):
            gain = gain * law(t)
        value = gain * value + vector[at["accelerometer.bias_m_s2"]]
        for law in _laws_at(effects, "reading"):
            value = value + law(t, motion.tip_angle)
        most = vector[at[RANGE]]
        shown: Array = np.clip(value, -most, most)
        return shown

    def _of_arrivals(self, motion: Motion, vector: Array) -> Array:
        """What the accelerometer reads more or less, m/s^2, where commands arrive as it is read: which comes first by
        some microseconds, no model says."""
        at = self.space.place
        later = reads_later(self._dead_s(vector), self.measured.cycle_s)
        share = float(vector[at[OF_ARRIVALS]]) - (1.0 if later else 0.0)
        return np.asarray(share * self._stiff_lever(vector) * motion.joint[:, 3])

    def _of_last_jump(self, motion: Motion, vector: Array, late: int) -> Array:
        """What a late accelerometer reads more of the jump of theta'' between two cycles than interpolation between
        them has of it, m/s^2. It reads before the jump or after, or some of both where its lag is a filter's.

        late: whole cycles of its delay.
        """
        at, alpha = self.space.place, motion.joint[:, 2]
        stays = np.exp(-2.0 * pi * vector[at["drive.bandwidth_hz"]] * self.measured.cycle_s)
        jump = np.zeros(len(alpha))
        jump[late + 1 :] = alpha[1 : len(alpha) - late] - stays * alpha[: len(alpha) - late - 1]
        return np.asarray(vector[at[OF_LAST_JUMP]] * self._stiff_lever(vector) * jump)

    def _stiff_lever(self, vector: Array) -> float:
        """The tip's acceleration by the joint's while no mode has moved, m."""
        at = self.space.place
        rest = 1.0 - sum(float(vector[at[f"modes.{i}.participation"]]) for i in range(self.modes))
        return rest * self.length

    def instants(self, vector: Array) -> Array:
        """Mid-exposure of each frame as the vector has it, s."""
        at, clock = self.space.place, self.frame_clock
        frames = self.measured.frames
        delay = vector[at["timing.capture_delay_s"]]
        if clock.arrival:
            stepped = self.in_order_s >= vector[at["timing.step_onset_s"]]
            instants = frames.received_s - delay - np.where(stepped, vector[at["timing.step_s"]], 0.0)
            instants = instants - vector[at["timing.delay_rate"]] * frames.received_s
        else:
            skew = 1.0 + 1e-6 * vector[at["timing.skew_ppm"]]
            instants = clock.grid_s * skew + vector[at["timing.arrival_s"]] - delay
            if frames.asked:  # requests carry the time that stepped
                stepped = self.in_order_s >= vector[at["timing.step_onset_s"]]
                instants = instants - np.where(stepped, vector[at["timing.step_s"]], 0.0)
        frames_late = vector[at["timing.stale_frames"]]
        if frames_late:
            period = 1.0 / self.model.camera.frame_rate_hz
            stale = frames.received_s >= vector[at["timing.stale_onset_s"]]
            instants = instants - np.where(stale, frames_late * period, 0.0)
        known: Array = instants
        return known

    def _arrivals(self, vector: Array) -> Array:
        at, clock, frames = self.space.place, self.frame_clock, self.measured.frames
        skew = 1.0 + 1e-6 * vector[at["timing.skew_ppm"]]
        middle = 0.5 * self.measured.duration_s
        due = clock.grid_s * skew + vector[at["timing.arrival_s"]]
        due = due + vector[at["timing.delay_rate"]] * (frames.received_s - middle)
        if frames.asked:  # requests and arrivals step together
            return np.asarray(due)
        stepped = self.in_order_s >= vector[at["timing.step_onset_s"]]
        known: Array = due + np.where(stepped, vector[at["timing.step_s"]], 0.0)
        return known

    def _displacement(self, motion: Motion, vector: Array) -> tuple[Array, Array]:
        at, frames = self.space.place, self.measured.frames
        exposure_s, cycle_s = self.model.camera.exposure_s, self.measured.cycle_s
        tilt, begin_s = vector[at["camera.rotation_px_per_rad"]], vector[at[CAMERA_BEGIN]]
        later = tilt - self.space["camera.rotation_px_per_rad"].start if begin_s > 0.0 else 0.0
        scene = (
            -vector[at["camera.scale_px_per_m"]] * self._tip_of_joint_seen(motion, vector)
            - (tilt - later) * motion.tip_angle
        )
        instants = self.instants(vector)
        value, rate = np.empty(len(instants)), np.empty(len(instants))
        expose(scene, instants, exposure_s, cycle_s, value, rate)
        value = value + vector[at["camera.offset_px"]]
        since = np.maximum(frames.received_s - begin_s, 0.0)
        if later:
            more, more_rate = np.empty(len(instants)), np.empty(len(instants))
            expose(-later * motion.tip_angle, instants, exposure_s, cycle_s, more, more_rate)
            value, rate = (
                value + np.where(since > 0.0, more, 0.0),
                rate + np.where(since > 0.0, more_rate, 0.0),
            )
        with np.errstate(over="ignore"):  # a candidate that runs away
            added = [
                np.where(since > 0.0, law(value, since), 0.0)
                for law in _laws_at(effects_in(vector, at), "image")
            ]
            for one in added:
                value = value + one
        sine, cosine = vector[at["camera.locking_sin_px"]], vector[at["camera.locking_cos_px"]]
        if sine or cosine:
            value = value + sine * np.sin(2.0 * pi * value) + cosine * np.cos(2.0 * pi * value)
        return value, rate

    def _tip_of_joint_seen(self, motion: Motion, vector: Array) -> Array:
        """The tip's path, m, if the joint was where a fine encoder saw it, as far as a simulated drive may be off."""
        if not self.measured.has_fine_encoder or self.joint_hz > 0.0:
            return motion.tip
        first = [self.space.place[f"modes.{i}.frequency_hz"] for i in range(self.modes)]
        modes = np.array([vector[place : place + 3] for place in first])
        joint = motion.motor if self.behind_encoder else motion.joint
        of, known, moved = self._joint_seen  # read at once: threads share it
        if joint is not of or not np.array_equal(modes, known):
            off = self._off(motion)
            moved = tip_moved(off, modes, self.length, self.measured.cycle_s)
            self._joint_seen = (joint, modes, moved)
        return motion.tip + moved


def _lagged(values: Array, turns: float) -> Array:
    """Values behind a first-order lag of 1/turns samples, exact for a ramp between them."""
    stays = np.exp(-turns)
    now = 1.0 - (1.0 - stays) / turns
    before = (1.0 - stays) / turns - stays
    start = values[0]
    return np.asarray(start + lfilter([now, before], [1.0, -stays], values - start))


def _laws_at(effects: list[tuple[str, dict[str, float]]], acts: Acts) -> list[Callable[..., Any]]:
    """The laws of effects that act at a site, with their own numbers."""
    found = [(CAUSES[cause], values) for cause, values in effects if CAUSES[cause].acts == acts]
    return [filled_in(cause.law, cause.arguments(values)) for cause, values in found if cause.law]


def _late(values: Array, cycles: float) -> Array:
    """Values `cycles` earlier, by Lagrange's cubic; before the first sample the first."""
    n = len(values)
    whole = int(np.floor(cycles))
    f = cycles - whole
    padded = np.concatenate((np.full(whole + 2, values[0]), values, (values[-1],)))
    base = np.arange(n) + 2  # of values[k - whole] in padded: k - whole + whole + 2
    newer, now, older, oldest = padded[base + 1], padded[base], padded[base - 1], padded[base - 2]
    between: Array = (
        newer * (-f * (1.0 - f) * (2.0 - f) / 6.0)
        + now * ((1.0 + f) * (1.0 - f) * (2.0 - f) / 2.0)
        + older * ((1.0 + f) * f * (2.0 - f) / 2.0)
        - oldest * ((1.0 + f) * f * (1.0 - f) / 6.0)
    )
    return between


def _upsampled(force: Array, factor: int) -> Array:
    """Band-limited interpolation of an input that was sampled, `factor` values a sample and one at the end.

    Taking it as held between samples would delay it by half a sample and hide a small nonlinearity. The ends are
    mirrored, so that they do not ring into each other.
    """
    n = len(force)
    pad = min(n - 1, 512)
    # odd reflection about both ends
    head = 2.0 * force[0] - force[pad:0:-1]
    tail = 2.0 * force[-1] - force[-2 : -pad - 2 : -1]
    whole = np.concatenate((head, force, tail))
    spectrum = np.fft.rfft(whole)
    fine = np.fft.irfft(spectrum, n=len(whole) * factor) * factor
    out = fine[pad * factor : (pad + n) * factor]
    return np.concatenate((out, [force[-1]]))
