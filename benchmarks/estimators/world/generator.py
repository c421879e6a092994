"""The benchmark's data: an arm in closed form, a late camera, noisy sensors.

This module is independent of controller/ and simulation/, so that an error in the estimators' model of the world does
not cancel. With l = -zeta w + i w sqrt(1 - zeta^2) and z = q' - conj(l) q, the mode's equation
q'' + 2 zeta w q' + w^2 q = f is z' = l z + f: under a force f = f0 + f1 t, z + f / l + f1 / l^2 turns and decays as
exp(l t), exactly.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from math import ceil, exp, sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.benchmarks.estimators.world.busy_computer import passed_on
from stillarm.benchmarks.estimators.world.regimes import CYCLE_S, DRIFT_TIME_S, FRAME_S, Arm, Regime

Values = NDArray[np.float64]
Counts = NDArray[np.int64]

_LEAST_TRIGGER_GAP_S = 0.002
_FIRST_EXPOSURE_S = 0.010


@dataclass(frozen=True)
class Motion:
    """Deflection of one mode, piece by piece: each row starts at start_s from (deflection_m, rate_m_s).

    pole: l of the piece, 1/s; force_m_s2, force_rate_m_s3: the force at the piece's start, and its slope. impacts_s:
    middle of each impact, or end of another force. Shapes (pieces,), (impacts,). forced_s: interval of each force that
    is not an impact, shape (forces, 2).
    """

    start_s: Values
    deflection_m: Values
    rate_m_s: Values
    pole: NDArray[np.complex128]
    force_m_s2: Values
    impacts_s: Values
    impact_velocity_m_s: Values
    force_rate_m_s3: Values
    forced_s: Values

    def piece_at(self, time_s: Values) -> Counts:
        """The piece that contains each of those times."""
        return np.maximum(np.searchsorted(self.start_s, time_s, side="right") - 1, 0)

    def at(self, time_s: Values) -> tuple[Values, Values, Values]:
        """Deflection, rate and acceleration at those times, each of the same shape."""
        row = self.piece_at(time_s)
        since = time_s - self.start_s[row]
        pole, slope = self.pole[row], self.force_rate_m_s3[row]
        force = self.force_m_s2[row] + slope * since
        bend = slope / pole**2
        first = self.rate_m_s[row] - pole.conj() * self.deflection_m[row]
        z = (first + self.force_m_s2[row] / pole + bend) * np.exp(pole * since) - force / pole - bend
        deflection = z.imag / pole.imag
        rate = z.real + pole.real * deflection
        return deflection, rate, force + 2.0 * pole.real * rate - np.abs(pole) ** 2 * deflection


@dataclass(frozen=True)
class Frames:
    """Camera frames that were read, in order; shape (frames,).

    number: counter of exposures; exposed_s: mid-exposure; read_cycle; started_cycle: n_i; stamp_s: NaN where unstamped.
    """

    number: Counts
    exposed_s: Values
    read_cycle: Counts
    started_cycle: Counts
    stamp_s: Values

    @property
    def delay_s(self) -> Values:
        """Capture delay: reading minus mid-exposure."""
        return self.read_cycle * CYCLE_S - self.exposed_s

    def without(self, lost: NDArray[np.bool_]) -> "Frames":
        """The frames that are not lost."""
        kept = ~lost
        return Frames(*(getattr(self, name)[kept] for name in self.__dataclass_fields__))


@dataclass(frozen=True)
class Data:
    """One trial. Shapes (cycles,) for what happens at cycle * CYCLE_S, (frames,) for frames.

    acceleration_m_s2: of the tip, with noise. seen_m: deflection that a frame shows, with noise, minus that of the
    first frame.
    """

    arm: Arm
    regime: Regime
    noise: float
    motion: Motion
    frames: Frames
    deflection_m: Values
    rate_m_s: Values
    acceleration_m_s2: Values
    seen_m: Values

    @property
    def amplitude_m(self) -> Values:
        """Momentary amplitude sqrt(q^2 + (q'/w)^2) with the w of the moment, shape (cycles,)."""
        time_s = cycle_times(len(self.deflection_m))
        return np.hypot(
            self.deflection_m, self.rate_m_s / np.abs(self.motion.pole[self.motion.piece_at(time_s)])
        )

    def with_frames_lost(self, lost: NDArray[np.bool_]) -> "Data":
        """The same trial without those frames; shape (frames,)."""
        return replace(self, frames=self.frames.without(lost), seen_m=self.seen_m[~lost])


def cycle_times(cycles: int) -> Values:
    """Times of the first cycles, s."""
    return CYCLE_S * np.arange(cycles, dtype=np.float64)


Excitation = Callable[[Arm, float, np.random.Generator], Motion]


@dataclass(frozen=True)
class Change:
    """Change of the mode from onset_s on, as factors of its earlier values."""

    onset_s: float
    frequency: float = 1.0


def generate(
    regime: Regime,
    noise: float,
    seed: tuple[int, ...],
    duration_s: float,
    arm: Arm,
    change: Change | None = None,
    excite: Excitation | None = None,
) -> Data:
    """Draw one trial. noise: of the accelerometer in each cycle, as a fraction of the amplitude's acceleration.

    excite: excitation of the arm; None: impacts, and `change`.
    """
    random = np.random.default_rng(seed)
    motion = (
        strike_again(arm, duration_s, random, change) if excite is None else excite(arm, duration_s, random)
    )
    frames = expose(regime, duration_s, random)
    time_s = cycle_times(round(duration_s / CYCLE_S))
    deflection, rate, acceleration = motion.at(time_s)
    unit = arm.angular_frequency**2 * arm.amplitude_m
    acceleration = acceleration + noise * unit * random.standard_normal(len(time_s))
    seen = motion.at(frames.exposed_s)[0] + vision_errors(arm, len(frames.number), random)
    return Data(
        arm, regime, noise, motion, frames, deflection, rate,
        np.clip(acceleration, -arm.range_m_s2, arm.range_m_s2), seen - seen[0],
    )  # fmt: skip


def vision_errors(arm: Arm, frames: int, random: np.random.Generator) -> Values:
    """White errors of the image, m."""
    return arm.vision_noise * arm.amplitude_m * random.standard_normal(frames)


def strike_again(
    arm: Arm, duration_s: float, random: np.random.Generator, change: Change | None = None
) -> Motion:
    """A freely decaying vibration with repeated impacts: constant force for impact_s, at any phase.

    An impact's size is drawn so that the amplitude after it lies in impact_to. Of the two velocities with that effect
    it uses the smaller.
    """
    w, unit = arm.angular_frequency, arm.amplitude_m
    phase = random.uniform(0.0, 2.0 * np.pi)
    amplitude = unit * random.uniform(*arm.impact_to)
    pieces: list[Piece] = [(0.0, amplitude * np.cos(phase), amplitude * w * np.sin(phase), pole_of(arm), 0.0)]
    impacts, velocities = [], []
    impact = random.uniform(*arm.impact_every_s)
    while impact < duration_s or change is not None:
        if change is not None and change.onset_s <= impact:
            arm = replace(arm, frequency_hz=arm.frequency_hz * change.frequency)
            w = arm.angular_frequency
            pieces.append((change.onset_s, *reach(pieces, change.onset_s), pole_of(arm), 0.0))
            change = None
            continue
        middle = impact + 0.5 * arm.impact_s
        deflection, rate = reach(pieces, middle)
        target = unit * random.uniform(*arm.impact_to)
        turn = w * sqrt(max(0.0, target**2 - deflection**2))
        velocity = min(turn - rate, -turn - rate, key=abs)
        pieces.append((impact, *reach(pieces, impact), pole_of(arm), velocity / arm.impact_s))
        end = impact + arm.impact_s
        pieces.append((end, *reach(pieces, end), pole_of(arm), 0.0))
        impacts.append(middle)
        velocities.append(velocity)
        impact = max(end, impact + random.uniform(*arm.impact_every_s))
    return motion_of(pieces, impacts, velocities)


Piece = tuple[float, float, float, complex, float] | tuple[float, float, float, complex, float, float]
"""A row of Motion: start, deflection, rate, pole, force, and the slope of the force if it is not constant."""


def motion_of(
    pieces: Iterable[Piece],
    impacts: list[float],
    velocities: list[float],
    forced: Iterable[tuple[float, float]] = (),
) -> Motion:
    """A Motion from its rows."""
    rows = [row if len(row) == 6 else (*row, 0.0) for row in pieces]
    start, deflection, rate, pole, force, slope = (np.array(column) for column in zip(*rows, strict=True))
    spans = np.array(list(forced), dtype=np.float64).reshape(-1, 2)
    return Motion(
        start,
        deflection,
        rate,
        pole.astype(np.complex128),
        force,
        np.array(impacts),
        np.array(velocities),
        slope,
        spans,
    )


def reach(pieces: list[Piece], time_s: float) -> tuple[float, float]:
    """Deflection and rate at a time within the last piece."""
    deflection, rate, _ = motion_of(pieces[-1:], [], []).at(np.array([time_s]))
    return float(deflection[0]), float(rate[0])


def pole_of(arm: Arm) -> complex:
    """l of the module's docstring, 1/s."""
    w, zeta = arm.angular_frequency, arm.damping_ratio
    return complex(-zeta * w, w * sqrt(1.0 - zeta * zeta))


def expose(regime: Regime, duration_s: float, random: np.random.Generator) -> Frames:
    """The times at which frames are exposed, stamped and read. Frames read after the end are left out."""
    count = ceil(duration_s / FRAME_S)
    k = np.arange(count, dtype=np.float64)
    skew = 1e-6 * random.uniform(-regime.skew_ppm, regime.skew_ppm)
    exposed: Values = _FIRST_EXPOSURE_S + FRAME_S * random.uniform() + k * FRAME_S * (1.0 + skew)
    if regime.triggered:
        exposed = exposed + np.cumsum(regime.trigger_walk_s * random.standard_normal(count))
        exposed = exposed + _variation(regime, count, random)
        exposed = np.maximum.accumulate(exposed - k * _LEAST_TRIGGER_GAP_S) + k * _LEAST_TRIGGER_GAP_S
    if regime.busy is not None:
        slow = replace(regime, jitter_s=0.0)
        kept, done, begun = passed_on(
            regime.busy, exposed, regime.delay_s, _variation(slow, count, random), random
        )
        read = np.ceil(done / CYCLE_S).astype(np.int64)
        started = np.maximum(np.floor(begun / CYCLE_S), 0.0).astype(np.int64)
        frames = Frames(k[kept].astype(np.int64), exposed[kept], read, started, np.full(len(read), np.nan))
        return frames.without(read >= round(duration_s / CYCLE_S))
    # Half a cycle less, which the wait for the next cycle adds, so that the delay at reading has the mean delay_s.
    arrival = exposed + regime.delay_s - 0.5 * CYCLE_S + _variation(regime, count, random)
    read = np.ceil(np.maximum.accumulate(arrival) / CYCLE_S).astype(np.int64)
    offset = 0.5 * FRAME_S + random.uniform(-regime.started_offset_s, regime.started_offset_s)
    ahead = np.clip(offset + regime.started_white_s * random.standard_normal(count), 0.0, FRAME_S)
    started = np.maximum(np.floor((exposed - ahead) / CYCLE_S), 0.0).astype(np.int64)
    stamps = np.full(count, np.nan)
    if regime.stamped:
        rate = 1.0 + 1e-6 * random.uniform(-regime.skew_ppm, regime.skew_ppm)
        stamps = (
            random.uniform(10.0, 1000.0) + rate * exposed + regime.stamp_s * random.standard_normal(count)
        )
    frames = Frames(k.astype(np.int64), exposed, read, started, stamps)
    return frames.without(read >= round(duration_s / CYCLE_S))


def _variation(regime: Regime, count: int, random: np.random.Generator) -> Values:
    white = random.standard_normal((2, count))
    keep = exp(-FRAME_S / DRIFT_TIME_S)
    slow = np.empty(count)
    state = white[0, 0]
    for k in range(count):
        slow[k] = state
        state = keep * state + sqrt(1.0 - keep * keep) * white[0, (k + 1) % count]
    return np.asarray(regime.drift_s * slow + regime.jitter_s * white[1])
