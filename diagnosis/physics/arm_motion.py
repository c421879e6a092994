"""How the arm moves under what a recording holds of its inputs: the stepper in free run, from the vector.

The motion follows from a part of the vector alone; one that differs from a known motion by jumps of a linear mode adds
that mode's answer to it.
"""

from dataclasses import dataclass
from functools import partial
from math import pi

import msgspec
import numpy as np
from numpy.typing import NDArray

from stillarm.common.causes import LAWS
from stillarm.common.files.beam import tip_slopes_per_m
from stillarm.common.files.model import Model
from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.physics.coasting_play import equivalent_behind_play
from stillarm.diagnosis.physics.computing import Lately, check_time
from stillarm.diagnosis.physics.declared_effects import effects_in, own_names
from stillarm.diagnosis.physics.linear_modes import add_decay, free_decay, tip_of
from stillarm.diagnosis.physics.measured_joint import answer_to_joint, smoothed
from stillarm.diagnosis.physics.quantities import (
    ARM_BEGIN,
    ARRIVAL,
    COASTING,
    DRIVE_BEGIN,
    SLOWING,
    SPEEDING,
    UNLIMITED,
)
from stillarm.diagnosis.physics.sampled_force import upsampled
from stillarm.diagnosis.physics.space import Space
from stillarm.diagnosis.physics.velocity_loop import equivalent_command
from stillarm.simulation.arm.compiled_laws import laws_of, obeyed
from stillarm.simulation.arm.free_run import driven_run, joint_run, modes_run, stepped_run
from stillarm.simulation.arm.state import Records, make_arm

Array = NDArray[np.float64]

JOINTS, ANSWERS = 3, 6
"""Runs of the joint, and answers and decays of a mode, that are remembered: memory against time."""
_OF_ARM = ("modes.", "jump.", "arm.")  # quantities that say nothing of the joint
_SEEN_ONLY = ("accelerometer.", "camera.", "timing.", "pair.offset")  # quantities that move nothing
OF_THE_LOOP = (
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
    SPEEDING,
    SLOWING,
)
"""Quantities of a velocity loop, as `equivalent_command` takes them."""
_OF_TIME = ("periodic_disturbance",)  # forces that ask for no state: a linear mode stays one
_TURN = 0.03  # rad of the first mode in a step of its laws: to 1e-7 of the amplitude
_TURN_OF_PAIR = 0.25  # to 1e-4: a pair has few samples a period
_SUBSTEPS_OF_PAIR = 2  # simulated steps a sample of a pair: its force is interpolated between samples


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
    of_joint: bytes
    """The same for motions in which the joint moved alike."""


@dataclass(frozen=True)
class _Joint:
    """What a joint did that meets no limit; starts: as `joint_run` gives them to `modes_run`; None where it meets one,
    and moves otherwise. command: that it obeys, rad/s."""

    joint: Array
    motor: Array
    starts: Array | None
    command: Array


class ArmMotion:
    """The arm of one recording; `move` is a pure function of the vector.

    impacts: cycles at which a segment with a state of its own begins. modes: bending modes. length_m: zero for a pair.
    behind_encoder: a play lies behind the joint sensor. joint_hz: up to which frequency the arm is moved by the joint
    as it was measured.
    """

    def __init__(
        self,
        measured: Measured,
        model: Model,
        space: Space,
        impacts: tuple[int, ...],
        modes: int,
        length_m: float,
        behind_encoder: bool,
        joint_hz: float,
        seen: bool,
    ) -> None:
        """space: of the quantities of arm, drive, sensors and timing, without added terms. seen: whether any sensor
        shows the arm; its modes stay at rest otherwise, which halves the time."""
        self._run = modes if seen else 0
        self.measured, self.model, self.space = measured, model, space
        self.modes, self.length = modes, length_m
        self.behind_encoder, self.joint_hz = behind_encoder, joint_hz
        self._joints: Lately[bytes, _Joint] = Lately(JOINTS)
        self._departures: Lately[bytes, tuple[Array, Array]] = Lately(JOINTS)
        self._answers: Lately[tuple[bytes, float, float], tuple[Array, Array]] = Lately(ANSWERS)
        self._decays: Lately[tuple[float, float], Array] = Lately(ANSWERS)
        self._acting: Lately[bytes, frozenset[str]] = Lately(1)
        self._slopes = np.array(tip_slopes_per_m(self.length or 1.0, self.modes))
        self._force = upsampled(measured.force, 2 * _SUBSTEPS_OF_PAIR) if measured.pair else np.empty(0)
        self._jump_cycles = np.array([0, *impacts], dtype=np.int64)
        self._command = np.nan_to_num(measured.command)
        self.cycle_times: Array = np.arange(measured.cycles, dtype=np.float64) * measured.cycle_s
        self._aged = bool(np.any(measured.joint_age_s > 0.05 * measured.cycle_s))
        self._jumps = {
            space.place[f"jump.{j}.{i}.{part}"]: (int(cycle), i, part == "v")
            for j, cycle in enumerate(self._jump_cycles)
            for i in range(self.modes)
            for part in "qv"
        }
        self._moving = _others(space, _SEEN_ONLY, own_names("sensitivity", "reading", "image"))
        of_arm = own_names("sensitivity", "reading", "image", "force", "friction", "frequency")
        self._of_joint = _others(space, (*_SEEN_ONLY, *_OF_ARM), of_arm)

    def forget(self) -> None:
        """Give the memory of what is remembered back."""
        for one in (self._joints, self._departures, self._answers, self._decays, self._acting):
            one.forget()

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
            dead_time_s=dead_s(vector, self.space),
        )
        if vector[at[COASTING[0]]] > 0.0:  # the limit is the motor's, not the link's that it strikes
            drive = msgspec.structs.replace(drive, max_acceleration_rad_s2=UNLIMITED)
        turn = _TURN_OF_PAIR if self.measured.pair else _TURN
        gap = float(vector[at["drive.gap_rad"]])
        laws = laws_of(effects, float(vector[at[ARM_BEGIN]]))
        arm, whole = make_arm(drive, self.measured.cycle_s, rows[: self._run], laws, gap, turn)
        arm["motor"], arm["rate"] = vector[at["start.theta"]], vector[at["start.omega"]]
        q, qdd = np.zeros((n, m)), np.zeros((n, m))
        if self.measured.pair:
            joint, motor = np.zeros((n, 4)), np.zeros((n, 2))
            force = vector[at["pair.gain"]] * (self._force + vector[at["pair.input_offset"]])
            driven_run(arm, force, self.measured.cycle_s, _SUBSTEPS_OF_PAIR, self._jump_cycles, jumps, q, qdd)
        else:
            moved = (q, qdd) if self._run == m else (np.empty((n, 0)), np.empty((n, 0)))
            jumps = np.ascontiguousarray(jumps[:, : self._run])
            joint, motor = self._run_freely(vector, effects, arm, whole, jumps, *moved)
        deflection, tip, tip_acceleration, tip_angle = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
        seen = self._as_measured(joint, motor, vector, rows, q, qdd) if self.joint_hz > 0.0 else joint
        tip_of(seen, q, qdd, self.length, self._slopes, deflection, tip, tip_acceleration, tip_angle)
        of, of_joint = vector[self._moving], self._key_of_joint(vector)
        return Motion(joint, motor, q, deflection, tip, tip_acceleration, tip_angle, of, of_joint)

    def _run_freely(
        self,
        vector: Array,
        effects: list[tuple[str, dict[str, float]]],
        arm: Records,
        whole: int,
        jumps: Array,
        q: Array,
        qdd: Array,
    ) -> tuple[Array, Array]:
        """The joint's and the motor's motion; fills in that of the modes. A joint that meets no limit is run once for
        all that differs in the arm alone."""
        n = self.measured.cycles

        def run() -> _Joint:
            command = self._obeyed(vector, effects)
            joint, motor, starts = np.empty((n, 4)), np.empty((n, 2)), np.empty((n, 2))
            free = joint_run(arm.copy(), command, whole, joint, motor, starts)
            return _Joint(joint, motor, starts if free else None, command)

        one = self._joints.of(self._key_of_joint(vector), run)
        if one.starts is not None:
            modes_run(arm, one.starts, one.joint, self._jump_cycles, jumps, q, qdd)
            return one.joint, one.motor
        joint, motor = np.zeros((n, 4)), np.zeros((n, 2))
        stepped_run(arm, one.command, whole, self._jump_cycles, jumps, joint, motor, q, qdd)
        return joint, motor

    def _key_of_joint(self, vector: Array) -> bytes:
        """The same for vectors that move the joint alike."""
        return bytes(vector[self._of_joint])

    def moved_from(self, near: Motion, vector: Array) -> Motion:
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
        return Motion(
            near.joint, near.motor, q, deflection, tip, tip_acceleration, tip_angle, of, near.of_joint
        )

    def _answers_linearly(self, vector: Array, modes: set[int]) -> bool:
        """Whether these modes keep their frequency, and answer a jump whatever else they do."""

        def at_work() -> frozenset[str]:
            effects = effects_in(vector, self.space.place)
            return frozenset(LAWS[cause].acts for cause, _ in effects if cause not in _OF_TIME)

        acting = self._acting.of(vector.tobytes(), at_work)
        return "frequency" not in acting and (0 not in modes or not acting & {"force", "friction"})

    def jump_at(self, place: int, vector: Array) -> tuple[int, int, bool] | None:
        """Cycle and mode of the impact whose jump is at that place of the vector, and whether of the rate; None for any
        other quantity, and for a mode that does not answer linearly. The state at the start is no impact's: a sensor
        may have looked before."""
        one = self._jumps.get(place)
        if one is None or one[0] == 0 or not self._answers_linearly(vector, {one[1]}):
            return None
        return one

    def decay_of(self, mode: int, vector: Array) -> tuple[Array, float]:
        """What a jump of a mode does from then on, as `free_decay` has it, and the tip's angle by it, rad/m."""
        return self._decay(vector, mode), float(self._slopes[mode])

    def _decay(self, vector: Array, mode: int) -> Array:
        """What a jump of a mode does from then on; the last few are remembered."""
        first = self.space.place[f"modes.{mode}.frequency_hz"]
        key = (float(vector[first]), float(vector[first + 1]))

        def decay() -> Array:
            found = np.empty((self.measured.cycles, 4))
            free_decay(*key, self.measured.cycle_s, found)
            return found

        return self._decays.of(key, decay)

    def _as_measured(
        self, joint: Array, motor: Array, vector: Array, rows: Array, q: Array, qdd: Array
    ) -> Array:
        """The joint's motion with what was measured of it; moves the modes with that, in place."""

        def departure() -> tuple[Array, Array]:
            reported = (motor if self.behind_encoder else joint)[:, 0]
            off = self.measured.position - self._aged_to_reading(reported)
            return smoothed(off, self.joint_hz, self.measured.cycle_s)

        key = self._key_of_joint(vector)
        slow, second = self._departures.of(key, departure)
        for i, (hz, damping, push) in enumerate(rows.tolist()):
            more, more_second = self._answers.of(
                (key, hz, damping), partial(answer_to_joint, second, hz, damping, 1.0, self.measured.cycle_s)
            )
            q[:, i] += push * more
            qdd[:, i] += push * more_second
        moved = joint.copy()
        moved[:, 0] += slow
        moved[:, 2] += second
        return moved

    def _aged_to_reading(self, value: Array) -> Array:
        if not self._aged:
            return value
        return np.interp(self.cycle_times - self.measured.joint_age_s, self.cycle_times, value)

    def reported(self, motion: Motion, which: int) -> Array:
        """Joint position (0) or velocity (1) as the drive reports it, joint_age_s old."""
        return self._aged_to_reading((motion.motor if self.behind_encoder else motion.joint)[:, which])

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
        own = [float(vector[at[name]]) for name in OF_THE_LOOP]
        decay = 2.0 * pi * float(vector[at["drive.bandwidth_hz"]])
        omega, cycle_s = float(vector[at["start.omega"]]), self.measured.cycle_s
        if own != [self.space[name].start for name in OF_THE_LOOP]:
            command = equivalent_command(command, cycle_s, decay, omega, float(begin_s), *own)
        play = [float(vector[at[name]]) for name in COASTING]
        if play[0] > 0.0:
            most = self.model.drive.max_acceleration_rad_s2
            command = equivalent_behind_play(command, cycle_s, decay, most, omega, *play)
        return command


def _others(space: Space, prefixes: tuple[str, ...], names: frozenset[str]) -> NDArray[np.int64]:
    """Places of the quantities but for those of these names, or whose names begin so."""
    kept = [at for name, at in space.place.items() if not name.startswith(prefixes) and name not in names]
    return np.array(kept, dtype=np.int64)


def dead_s(vector: Array, space: Space) -> float:
    """When a command arrives at the drive, s after its cycle began."""
    at = space.place
    return max(0.0, float(vector[at["drive.dead_time_s"]] + vector[at[ARRIVAL]]))
