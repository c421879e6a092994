"""Measured data on the controller's grid: what a diagnosis works on, whatever it was recorded with."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.noise import fast_noise, is_fine_encoder, is_fine_image

Array = NDArray[np.float64]

_AT_REST = 0.01  # of the largest command


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
    def told_to_move(self) -> NDArray[np.bool_]:
        """Whether the joint was told to move, at each cycle, (cycles,)."""
        speed = np.abs(np.nan_to_num(self.command))
        return np.asarray(speed > _AT_REST * float(np.max(speed, initial=0.0)))

    def rests_about(self, cycle: int, reach: int) -> bool:
        """Whether the joint was not told to move within so many cycles of one."""
        return not bool(self.told_to_move[max(cycle - reach, 0) : cycle + reach].any())

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


def dated_by_requests(measured: Measured) -> Measured:
    """The same data with each triggered frame dated by when it was asked for."""
    frames = measured.frames
    return replace(measured, frames=replace(frames, captured_s=frames.started_s, asked=True))


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
