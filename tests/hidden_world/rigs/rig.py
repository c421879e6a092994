"""What one recording is made of: the arm, its drive, its sensors, its camera, what is done with it. SI units."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]

TICK_S = 0.001
"""A cycle of the controller."""
FINE = 10
"""Steps of the integrator in a cycle."""
STEP_S = TICK_S / FINE
SLOPES = (1.3765, 4.781, 7.849)
"""Slope of the tip over tip deflection / length, of a uniform clamped beam's first three modes."""


@dataclass(frozen=True)
class Mode:
    """A bending mode. push: what a force at the tip gives it, relative to the first."""

    frequency_hz: float
    damping_ratio: float
    participation: float
    push: float = 1.0


@dataclass(frozen=True)
class Drive:
    bandwidth_hz: float
    dead_time_s: float  # a multiple of STEP_S
    max_velocity_rad_s: float
    max_acceleration_rad_s2: float


@dataclass(frozen=True)
class Encoder:
    """quantum_rad: 0 is none. at_motor: it does not see what the gear does."""

    noise_rad: float
    speed_noise_rad_s: float
    quantum_rad: float
    at_motor: bool


@dataclass(frozen=True)
class Accelerometer:
    scale: float
    noise_m_s2: float
    bias_m_s2: float
    range_m_s2: float
    colour: float


@dataclass(frozen=True)
class Camera:
    triggered: bool
    frame_rate_hz: float
    exposure_s: float
    readout_s: float
    scale_px_per_m: float
    rotation_px_per_rad: float
    offset_px: float
    noise_px: float
    colour: float
    stamped: bool
    stamp_offset_s: float
    stamp_ppm: float
    stamp_jitter_s: float
    stamp_quantum_s: float
    counts_exposures: bool


@dataclass(frozen=True)
class Arrival:
    """received - middle of the exposure: mean, spread, and how much of its variance wanders with which time constant.

    grab: "latest" (dated when the image was there) or "next" (dated when it was asked for).
    """

    mean_s: float
    std_s: float
    wander_share: float
    wander_time_s: float
    one_sided: bool
    grab: str
    received_quantum_s: float


@dataclass(frozen=True)
class Nuisance:
    """What no cause describes. third: a mode that the model file does not know. warmth: relative wander of the damping.
    skew: relative difference of the first mode's stiffness between the two sides."""

    third: Mode | None = None
    warmth: float = 0.0
    warmth_time_s: float = 15.0
    skew: float = 0.0


@dataclass(frozen=True)
class Effect:
    """size: in the unit that catalogue.py says; onset_s: 0 is from the beginning. extras: what else the form needs."""

    cause: str
    form: str
    size: float
    sign: int = 1
    onset_s: float = 0.0
    seed: int = 0
    extras: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Rig:
    seed: int
    duration_s: float
    length_m: float
    modes: tuple[Mode, ...]
    drive: Drive
    encoder: Encoder | None
    accelerometer: Accelerometer | None
    camera: Camera
    arrival: Arrival
    nuisance: Nuisance
    swinging_m: float = 0.0
    swinging_phase: float = 0.0
    farthest_rad: float = 0.5
    fastest_rad_s: float = 0.5

    @property
    def cycles(self) -> int:
        return round(self.duration_s / TICK_S)

    @property
    def steps(self) -> int:
        return self.cycles * FINE


def luck(seed: int, *what: int) -> np.random.Generator:
    """The generator of one thing: what is drawn for another does not move it."""
    return np.random.default_rng((seed, *what))


def log_uniform(chance: np.random.Generator, low: float, high: float) -> float:
    """A number whose logarithm is uniform."""
    return float(np.exp(chance.uniform(np.log(low), np.log(high))))
