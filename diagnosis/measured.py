"""Measured data on the controller's grid: what a diagnosis works on, whatever it was recorded with."""

from dataclasses import dataclass, replace
from functools import cached_property
from math import nan

import numpy as np
from numpy.typing import NDArray

from stillarm.common.datagrams.visual_sample import TrackingStatus
from stillarm.common.files.model import Model
from stillarm.common.recording.reader import Recording
from stillarm.common.user_error import UserError
from stillarm.diagnosis.fast_rows import row_step_s, rows_in_order
from stillarm.diagnosis.fine_sensors import is_fine_encoder, is_fine_image
from stillarm.diagnosis.imposed_joint import imposed_command
from stillarm.diagnosis.robust import bridged, std_about_median
from stillarm.diagnosis.struck_flanks import fast_noise

Array = NDArray[np.float64]

_OUTSTANDING = 6.0  # robust deviations of the rows' steps
_LEAST_ROWS_A_PERIOD = 4  # of the first mode: fewer do not show how it decays between them
_STEP_CYCLES = 1.5  # a gap in time_s longer than this may be lost rows, or a clock that stepped


@dataclass(frozen=True)
class Frames:
    """Visual samples, in the order in which they were read; times in s from the start of the fast data.

    counter: as recorded. displacement_px: NaN where not measured. captured_s: camera's stamp or NaN.
    asked: captured_s is no stamp, but when a triggered exposure was asked for (started_s). counted: the counter counts
    exposures, mended where arrivals and images told so.
    """

    counter: NDArray[np.int64]
    received_s: Array
    started_s: Array
    displacement_px: Array
    captured_s: Array
    asked: bool = False
    counted: bool = False

    def __len__(self) -> int:
        return len(self.received_s)


@dataclass(frozen=True)
class ClockGap:
    """A place where time_s does not go on by one cycle: at row's place `cycle`, by `extra_s` too much or too little."""

    cycle: int
    extra_s: float


@dataclass(frozen=True)
class Measured:
    """One recording: a uniform grid of n cycles with NaN where nothing was measured, and the frames.

    origin_s: time_s of the first row. command: rad/s, held over gaps; none: neither command nor joint motion known.
    imposed: no command was recorded, and the one here makes the joint move as it was measured.
    force: input of a pair (one input, one output), in its own unit; empty otherwise.
    backward: clock steps back, already taken out (time cannot go back); gaps: forward jumps, taken as lost rows.
    """

    name: str
    cycle_s: float
    origin_s: float
    command: Array
    reference: Array
    acceleration: Array
    position: Array
    velocity: Array
    joint_age_s: Array
    deflection: Array
    frames: Frames
    force: Array
    pair: bool = False
    imposed: bool = False
    backward: tuple[ClockGap, ...] = ()
    gaps: tuple[ClockGap, ...] = ()

    @property
    def cycles(self) -> int:
        """Length of the grid."""
        return len(self.command)

    @property
    def duration_s(self) -> float:
        """Time that the grid spans, s."""
        return self.cycles * self.cycle_s

    @cached_property
    def has_fine_encoder(self) -> bool:
        """Whether the position has noise and steps well below what a simulated drive is taken to be right to."""
        return not self.pair and is_fine_encoder(self.position)

    @cached_property
    def has_fine_image(self) -> bool:
        """Whether the images' noise lies below what trackers stray."""
        return is_fine_image(self.frames.displacement_px)

    @cached_property
    def fast_noise_m_s2(self) -> float:
        """The accelerometer's white noise, whatever the arm does."""
        return fast_noise(self.acceleration)

    def channel(self, name: str) -> Array:
        """A fast channel's samples on the grid."""
        return {
            "acceleration": self.acceleration,
            "joint_position": self.position,
            "joint_velocity": self.velocity,
            "deflection": self.deflection,
        }[name]


def read_measured(recording: Recording, model: Model) -> Measured:
    """The recording's channels. Raises UserError where there is nothing to diagnose."""
    if recording.counts.get("/pair"):
        return _pair(recording)
    if not recording.counts.get("/fast"):
        raise UserError(
            f"{recording.path}: holds no cycles (/fast) and no pair of input and output; "
            "`stillarm import` brings measured data in"
        )
    fast = recording.columns("/fast")
    in_order = rows_in_order(fast["time_s"], fast)
    fast = {name: values[in_order] for name, values in fast.items()}
    cycle_s = row_step_s(fast["time_s"], model.timing.cycle_s)
    hz = model.arm.modes[0].frequency_hz
    if cycle_s * hz > 1.0 / _LEAST_ROWS_A_PERIOD:
        raise UserError(
            f"{recording.path}: /fast: rows come every {cycle_s:g} s, too far apart for arm.modes[0].frequency_hz = "
            f"{hz:g}; record at least {_LEAST_ROWS_A_PERIOD} a period, or correct the model's frequency"
        )
    time, backward, gaps = _unrolled(fast["time_s"], cycle_s)
    origin = float(fast["time_s"][0])
    place = np.rint((time - time[0]) / cycle_s).astype(np.int64)
    n = int(place[-1]) + 1
    if n > 40 * len(time) + 100_000:
        raise UserError(
            f"{recording.path}: /fast: {len(time)} rows span {n * cycle_s:.0f} s, most of them {cycle_s:g} s apart; "
            "cut the recording where it was interrupted, and diagnose each part by itself"
        )

    def grid(values: Array) -> Array:
        out = np.full(n, nan)
        out[place] = values
        return out

    there = np.zeros(n, bool)
    there[place] = True

    def sent(values: Array) -> Array:
        """What the drive was sent: held where a row has none, between its neighbours' where the row itself is missing,
        as holding would leave the joint behind with every such row for good."""
        held = _held(grid(values))
        held[~there] = np.interp(np.flatnonzero(~there), np.flatnonzero(there), held[there])
        return held

    reference = sent(fast["joint_velocity_reference_rad_s"])
    command = sent(fast["joint_velocity_command_rad_s"])
    if np.isnan(command).all():
        command = reference
    position, velocity = grid(fast["joint_position_rad"]), grid(fast["joint_velocity_rad_s"])
    imposed = None
    if np.isnan(command).all():
        imposed = imposed_command(position, velocity, model.drive, cycle_s)
    return Measured(
        name=str(recording.path),
        cycle_s=cycle_s,
        origin_s=origin,
        command=command if imposed is None else imposed,
        reference=reference,
        acceleration=grid(fast["acceleration_m_s2"]),
        position=position,
        velocity=velocity,
        joint_age_s=np.nan_to_num(grid(fast["joint_age_s"])),
        deflection=grid(fast["deflection_m"]),
        frames=_frames(recording, origin, backward),
        force=np.empty(0),
        imposed=imposed is not None,
        backward=backward,
        gaps=() if _are_missed_deadlines(recording, gaps, cycle_s) else gaps,
    )


def dated_by_requests(measured: Measured) -> Measured:
    """The same data with each triggered frame dated by when it was asked for."""
    frames = measured.frames
    return replace(measured, frames=replace(frames, captured_s=frames.started_s, asked=True))


def _are_missed_deadlines(recording: Recording, gaps: tuple[ClockGap, ...], cycle_s: float) -> bool:
    """Whether the loop that recorded them says that it has missed as many cycles as are not there: no clock was set."""
    told = 0
    for topic in ("/link", "/loop"):
        if recording.counts.get(topic):
            told = max(told, int(np.max(recording.columns(topic)["deadline_misses"], initial=0)))
    return told > 0 and told >= round(sum(gap.extra_s for gap in gaps) / cycle_s)


def reclocked(measured: Measured, gap: ClockGap) -> Measured:
    """The same data if the gap is no loss of rows but a clock that stepped on by gap.extra_s."""
    shift = round(gap.extra_s / measured.cycle_s)
    keep = np.ones(measured.cycles, dtype=bool)
    keep[gap.cycle - shift : gap.cycle] = False
    frames = measured.frames
    at = gap.cycle * measured.cycle_s
    late = np.where(frames.received_s >= at - 0.5 * measured.cycle_s, shift * measured.cycle_s, 0.0)
    begun = np.where(frames.started_s >= at - 0.5 * measured.cycle_s, shift * measured.cycle_s, 0.0)
    moved = replace(frames, received_s=frames.received_s - late, started_s=frames.started_s - begun)
    if frames.asked:
        moved = replace(moved, captured_s=moved.started_s)
    others = tuple(
        ClockGap(one.cycle - (shift if one.cycle > gap.cycle else 0), one.extra_s)
        for one in measured.gaps
        if one != gap
    )
    return replace(
        measured,
        command=measured.command[keep],
        reference=measured.reference[keep],
        acceleration=measured.acceleration[keep],
        position=measured.position[keep],
        velocity=measured.velocity[keep],
        joint_age_s=measured.joint_age_s[keep],
        deflection=measured.deflection[keep],
        frames=moved,
        gaps=others,
    )


def first_part(measured: Measured, duration_s: float) -> Measured:
    """The same data up to duration_s after their start."""
    n = min(measured.cycles, max(1, round(duration_s / measured.cycle_s)))
    frames = measured.frames
    seen = frames.received_s < n * measured.cycle_s
    return replace(
        measured,
        **{name: getattr(measured, name)[:n] for name in _ON_THE_GRID},
        force=measured.force[:n],
        frames=replace(
            frames,
            counter=frames.counter[seen],
            received_s=frames.received_s[seen],
            started_s=frames.started_s[seen],
            displacement_px=frames.displacement_px[seen],
            captured_s=frames.captured_s[seen],
        ),
        backward=tuple(gap for gap in measured.backward if gap.cycle < n),
        gaps=tuple(gap for gap in measured.gaps if gap.cycle < n),
    )


_ON_THE_GRID = (
    "command",
    "reference",
    "acceleration",
    "position",
    "velocity",
    "joint_age_s",
    "deflection",
)


def _unrolled(time: Array, cycle_s: float) -> tuple[Array, tuple[ClockGap, ...], tuple[ClockGap, ...]]:
    """Row times with steps back taken out; where they were, and where the clock jumped forward."""
    step = np.diff(time)
    usual = float(np.median(step)) if len(step) else cycle_s
    out = time.copy()
    backward, gaps = [], []
    scatter = std_about_median(step) if len(step) else 0.0
    early = (step <= 0.0) | (usual - step > _OUTSTANDING * scatter)  # than stamps that scatter are anyhow
    for i in np.flatnonzero(early & (step < 0.25 * min(usual, cycle_s))):
        extra = float(step[i]) - usual
        out[i + 1 :] -= extra
        backward.append((i + 1, extra))
    for i in np.flatnonzero(step > usual + (_STEP_CYCLES - 0.5) * max(usual, cycle_s)):
        gaps.append((i + 1, float(step[i]) - usual))
    place = np.rint((out - out[0]) / cycle_s).astype(np.int64)
    return (
        out,
        tuple(ClockGap(int(place[i]), extra) for i, extra in backward),
        tuple(ClockGap(int(place[i]), extra) for i, extra in gaps),
    )


def _held(values: Array) -> Array:
    """Each missing value is the last one before it (the first ones: the first there is)."""
    known = np.flatnonzero(~np.isnan(values))
    if not len(known):
        return values
    place = np.maximum.accumulate(np.where(np.isnan(values), -1, np.arange(len(values))))
    return values[np.where(place < 0, known[0], place)]


def _frames(recording: Recording, origin_s: float, backward: tuple[ClockGap, ...]) -> Frames:
    if not recording.counts.get("/frames"):
        empty = np.empty(0)
        return Frames(np.empty(0, np.int64), empty, empty, empty, empty)
    found = recording.columns("/frames")
    seen = np.isin(found["status"], (TrackingStatus.MEASURED,))
    displacement = np.where(seen, found["displacement_px"], nan)
    received, started = found["received_s"] - origin_s, found["started_s"] - origin_s
    if backward:  # frames' clock stepped back with the rows'
        step = np.diff(received)
        for i, gap in zip(
            np.flatnonzero(step < -0.5 * min(-gap.extra_s for gap in backward)), backward, strict=False
        ):
            received[i + 1 :] -= gap.extra_s
            started[i + 1 :] -= gap.extra_s
    return Frames(found["frame"].astype(np.int64), received, started, displacement, found["captured_s"])


def _pair(recording: Recording) -> Measured:
    found = recording.columns("/pair")
    rate = float(recording.header.notes["rate_hz"])
    n = len(found["input"])
    none = np.full(n, nan)
    empty = np.empty(0)
    frames = Frames(np.empty(0, np.int64), empty, empty, empty, empty)
    force = bridged(found["input"])
    if not len(force) or float(np.ptp(force)) == 0.0:
        raise UserError(
            f"{recording.path}: the input never changes, so that the output tells nothing of what it does; "
            "map another column to input"
        )
    return Measured(
        str(recording.path), 1.0 / rate, 0.0, np.zeros(n), np.zeros(n), none, none, none,
        np.zeros(n), found["output"], frames, force, pair=True,
    )  # fmt: skip
