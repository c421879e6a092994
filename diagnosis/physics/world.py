"""From the vector to what each channel should have shown: the simulation of a recording, in free run.

Channels: acceleration, joint_position, joint_velocity, deflection (on the controller's grid); displacement (per frame);
arrival (per frame: when it was read, less when it was exposed).
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from math import isfinite, sqrt
from time import monotonic

import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.model import Model
from stillarm.diagnosis.data.channels import ARM_CHANNELS, FRAME_CHANNELS, JOINT_CHANNELS, present_channels
from stillarm.diagnosis.data.frame_clock import FrameClock, frame_clock
from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.data.noise import LEAST, resolution
from stillarm.diagnosis.data.robust import white_noise
from stillarm.diagnosis.physics.accelerometer import Accelerometer, without_strikes
from stillarm.diagnosis.physics.arm_motion import ANSWERS, JOINTS, ArmMotion, Motion
from stillarm.diagnosis.physics.camera import Camera
from stillarm.diagnosis.physics.channel_quantities import own_places
from stillarm.diagnosis.physics.computing import Lately, limited
from stillarm.diagnosis.physics.declared_effects import is_behind_encoder
from stillarm.diagnosis.physics.jump_answers import JumpAnswers
from stillarm.diagnosis.physics.measured_joint import answer_to_path, noise_at_tip, tip_moved, within_reach
from stillarm.diagnosis.physics.memory import remembers
from stillarm.diagnosis.physics.quantities import QUARTZ, SKEW, Layout
from stillarm.diagnosis.physics.space import Added, Quantity

Array = NDArray[np.float64]

_JUST_S = 1e-7  # less than between frames read at once
_GRANTED = 0.9  # of what a simulated drive may be off; the tenth that is not shows a fit the way
_STROKE_S = 0.02  # to either side of an impact: a soft hammer's lasts 5 to 20 ms
_UNSEEN = 0.1  # of an image's noise: n x^2 / 2 = 10 nats in two thousand images, as much as chance brings
_ABOUT_EXPOSED_S = 0.02  # by which an image's instant is uncertain


@dataclass
class Predicted:
    """What each channel should show, by name, and displacement's rate at the frames, px/s (for doubt of instants).
    vector: that it follows from, in that world."""

    channels: dict[str, Array]
    rate_px_s: Array
    vector: Array
    world: "World"
    moved: Motion | None = None
    """The arm's motion, as long as it is remembered."""

    @property
    def motion(self) -> Motion:
        """The arm's motion; worked out anew where it was forgotten, whatever time is left."""
        if self.moved is None:
            with limited(None, monotonic):
                self.moved = self.world.move(self.vector)
        return self.moved

    def forget(self) -> None:
        """Give the motion's memory back: five times that of the channels."""
        self.moved = None


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
        borne_out: frozenset[int] = frozenset(),
    ) -> None:
        """Lay out the vector. behind_encoder: a play lies behind the joint sensor. clock: the frames', if known.
        added: terms without a formula. unjudged_s: spans in which something unknown holds the arm, from and to.
        joint_hz: up to which frequency the arm is moved by the joint as it was measured. strokes: cycles about which
        the accelerometer is not judged; those of the impacts, if not given. borne_out: cycles of impacts that stand
        beside a better model: no weaker one drops them."""
        self.borne_out = borne_out
        self.strokes = impacts if strokes is None else strokes
        self.added, self.unjudged_s, self.joint_hz = added, unjudged_s, joint_hz
        self.measured, self.model = measured, model
        self.impacts, self.extra_modes = impacts, extra_modes
        self.behind_encoder = behind_encoder or is_behind_encoder(model)
        self.frame_clock: FrameClock = clock or frame_clock(measured.frames, model)
        self.modes = len(model.arm.modes) + extra_modes
        self.length = 0.0 if measured.pair else (model.arm.length_m or 1.0)
        self.cycle_times: Array = np.arange(measured.cycles, dtype=np.float64) * measured.cycle_s
        present = present_channels(measured, self.frame_clock)
        self.channels, self.channels_left_out = present.values, present.left_out
        for span in unjudged_s:
            self._leave_out(span)
        self._leave_out_strokes()
        self._layout = Layout(
            measured, model, self.modes, len(impacts) + 1, self.length, self.frame_clock,
            frozenset(self.channels),
        )  # fmt: skip
        self.space = self._layout.space()
        self._arm = ArmMotion(
            measured, model, self.space, impacts, self.modes, self.length, self.behind_encoder, joint_hz,
            seen=not set(ARM_CHANNELS).isdisjoint(self.channels),
        )  # fmt: skip
        self._accelerometer = Accelerometer(measured, self.space, self.modes, self.length)
        self._camera = Camera(measured, model, self.space, self.frame_clock)
        self._jumps = JumpAnswers(self._arm, self._accelerometer, self._camera, 2 * self.modes)
        for group in added:
            for name in group.amounts:
                self.space.add(Quantity(name, 0.0, step=1e-3 * group.prior_std, prior_std=group.prior_std))
        self._own = {name: own_places(name, self.space, added) for name in self.channels}
        self._tip_follows_encoder = self._encoder_tells_tip()
        self._variation: dict[str, float] = {}
        self._resolution: dict[str, float] = {}
        self._offs: Lately[bytes, Array] = Lately(JOINTS)
        self._answers: Lately[tuple[bytes, float, float], Array] = Lately(ANSWERS)

    def changed(
        self,
        impacts: tuple[int, ...] | None = None,
        extra_modes: int | None = None,
        behind_encoder: bool | None = None,
        added: tuple[Added, ...] | None = None,
        unjudged_s: tuple[tuple[float, float], ...] | None = None,
        joint_hz: float | None = None,
        strokes: tuple[int, ...] | None = None,
        borne_out: frozenset[int] | None = None,
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
            self.borne_out if borne_out is None else borne_out,
        )

    @property
    def unjudged_ends(self) -> set[int]:
        """The cycles at which what is not judged ends: the arm comes out of that in any state."""
        return {round(end / self.measured.cycle_s) for _, end in self.unjudged_s}

    def forget(self) -> None:
        """Give the memory of what simulations have in common back, of a world that is kept for what it has shown."""
        self._arm.forget()
        self._jumps.forget()
        self._offs.forget()
        self._answers.forget()

    def with_measured(self, measured: Measured, impacts: tuple[int, ...] | None = None) -> "World":
        """Other data, or the same dated otherwise, in a world of the same structure."""
        return World(
            measured, self.model, self.impacts if impacts is None else impacts, self.extra_modes,
            self.behind_encoder, None, self.added, self.unjudged_s, self.joint_hz,
            borne_out=self.borne_out,
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

    def slopes_of_jump(self, name: str, vector: Array, base: Predicted) -> dict[str, Array] | None:
        """Derivative of each channel that an impact's jump moves, (samples,), at a vector that makes `base` of the
        recording; None for any other quantity, and where it does not follow from another impact's."""
        return self._jumps.slopes(self.space.place[name], vector, base.channels)

    def baseline_names(self) -> list[str]:
        """What the baseline refits (the contract's list), as far as this recording's channels can show it."""
        return self._layout.baseline_names()

    def with_baseline(self, own: Iterable[str]) -> tuple[str, ...]:
        """What a fit frees that refits the baseline beside its own. A clock that is taken for wrong has one rate."""
        names = dict.fromkeys((*self.baseline_names(), *own))
        if SKEW in names:
            names.pop(QUARTZ, None)
        return tuple(names)

    def variation(self, channel: str) -> float:
        """Standard deviation of what a channel measured, in its unit; of the arrivals about the frames' grid."""
        if channel not in self._variation:
            values = self.channels[channel]
            about = self.frame_clock.grid_s if channel == "arrival" else 0.0
            self._variation[channel] = float(np.nanstd(values - about))
        return self._variation[channel]

    def resolution(self, channel: str) -> float:
        """The step to which a channel's values are rounded, in its unit; next to nothing where they are not. None is
        told of arrivals, which differ by a frame."""
        if channel == "arrival":
            return 0.0
        if channel not in self._resolution:
            values = self.channels[channel]
            step = resolution(values[np.isfinite(values)])
            self._resolution[channel] = step if isfinite(step) else 0.0
        return self._resolution[channel]

    def times_of(self, channel: str) -> Array:
        """When each of a channel's samples was read, s from the first cycle."""
        return self.measured.frames.received_s if channel in FRAME_CHANNELS else self.cycle_times

    def step_s(self, channel: str) -> float:
        """Time between a channel's samples, s."""
        return 1.0 / self.model.camera.frame_rate_hz if channel in FRAME_CHANNELS else self.measured.cycle_s

    def just_before(self, frames: int | NDArray[np.bool_]) -> Array:
        """Instants just before those frames, by place or mask, were read, s: an onset there counts for them."""
        return np.asarray(self._camera.in_order_s[frames] - _JUST_S)

    def instants(self, vector: Array) -> Array:
        """Mid-exposure of each frame as the vector has it, s."""
        return self._camera.instants(vector)

    def move(self, vector: Array) -> Motion:
        """The arm's motion under the recorded inputs. Raises OutOfTime within a limit that has passed."""
        return self._arm.move(vector)

    def predict(self, vector: Array, near: Predicted | None = None) -> Predicted:
        """All channels that were measured. near: of this world; its motion, and its channels, are taken where the
        vector says the same of them."""
        remembers(self)
        motion = self._arm.moved_from(near.motion, vector) if near is not None else self._arm.move(vector)
        found: dict[str, Array] = {}
        rate = np.empty(0) if near is None else near.rate_px_s
        for name in self.channels:
            if near is not None and self._shows_the_same(name, motion, vector, near):
                found[name] = near.channels[name]
                continue
            if name == "displacement":
                tip = self._tip_of_joint_seen(motion, vector)
                shown, rate = self._camera.displacement(motion, tip, vector)
            else:
                shown = self._shown(name, motion, vector)
            found[name] = self._with_terms(name, shown, vector)
        return Predicted(found, rate, vector.copy(), self, motion)

    def _shown(self, name: str, motion: Motion, vector: Array) -> Array:
        """What a channel should show, images aside, without terms that are added to it."""
        if name == "joint_position":
            return self._seen_joint(motion, 0)
        if name == "joint_velocity":
            return self._seen_joint(motion, 1)
        if name == "deflection":
            return np.asarray(motion.deflection + vector[self.space.place["pair.offset"]])
        if name == "acceleration":
            return self._accelerometer.shown(motion, vector)
        return self._camera.arrivals(vector)

    def _with_terms(self, name: str, shown: Array, vector: Array) -> Array:
        """A channel with the terms without a formula that are added to it, in the vector's amounts."""
        for group in self.added:
            if name in group.columns:
                amounts = vector[[self.space.place[one] for one in group.amounts]]
                if amounts.any():
                    shown = shown + group.columns[name] @ amounts
        return shown

    def _shows_the_same(self, name: str, motion: Motion, vector: Array, near: Predicted) -> bool:
        """Whether a channel shows the same of a motion and a vector as in another prediction."""
        if name in JOINT_CHANNELS:
            same = motion.joint is near.motion.joint
        else:
            same = motion is near.motion or name == "arrival"
        own = self._own[name]
        return same and bool((vector[own] == near.vector[own]).all())

    def residual(self, name: str, predicted: Predicted, vector: Array) -> Array:
        """A channel's measured values less those predicted, as the data are judged by."""
        off: Array = self.channels[name] - predicted.channels[name]
        if name != "acceleration" or vector[self.space.place["drive.gap_rad"]] == 0.0:
            return off
        omega, noise = predicted.motion.joint[:, 1], self.measured.fast_noise_m_s2
        return without_strikes(off, omega, self.length, noise, self.measured.cycle_s)

    def reported_position(self, vector: Array) -> Array:
        """The joint's position as the drive would report it, rad, whether it was measured or not."""
        return self._seen_joint(self.move(vector), 0)

    def _seen_joint(self, motion: Motion, which: int) -> Array:
        """The same as the data are judged by. To a fine encoder what a simulated drive may be off is no noise, of which
        many samples would make a discovery: most of it is granted, and the rest tells a fit the way."""
        granted = which == 0 and self.measured.has_fine_encoder and self.joint_hz == 0.0
        return self._arm.reported(motion, which) + (_GRANTED * self._off(motion) if granted else 0.0)

    def _off(self, motion: Motion) -> Array:
        """By how much a fine encoder saw the joint elsewhere, rad, as far as a simulated drive may be off."""
        seen = self.measured.position
        return self._offs.of(motion.of_joint, lambda: within_reach(seen, self._arm.reported(motion, 0)))

    def _encoder_tells_tip(self) -> bool:
        """Whether an encoder is so fine that its noise, through the arm's resonances, would not show in the image."""
        if not self.measured.has_fine_encoder or self.joint_hz > 0.0:
            return False
        arm, camera, position = self.model.arm, self.model.camera, self.measured.position
        modes = np.array([(one.frequency_hz, one.damping_ratio, one.participation) for one in arm.modes])
        known = position[np.isfinite(position)]
        noise_rad = max(white_noise(known, 2), resolution(known) / sqrt(12.0))
        moved_m = noise_at_tip(noise_rad, modes, self.length, self.measured.cycle_s)
        return moved_m * abs(camera.scale_px_per_m) < _UNSEEN * max(
            LEAST["displacement"], camera.noise_std_px
        )

    def _tip_of_joint_seen(self, motion: Motion, vector: Array) -> Array:
        """The tip's path, m, if the joint was where a fine encoder saw it, as far as a simulated drive may be off."""
        if not self._tip_follows_encoder:
            return motion.tip
        first = [self.space.place[f"modes.{i}.frequency_hz"] for i in range(self.modes)]
        modes = np.array([vector[place : place + 3] for place in first])
        off, step_s = self._off(motion), self.measured.cycle_s

        def answer(hz: float, damping: float) -> Array:
            work = partial(answer_to_path, self.length * off, hz, damping, step_s)
            return self._answers.of((motion.of_joint, hz, damping), work)

        return motion.tip + tip_moved(off, modes, self.length, answer)
