"""A rig with its effects as it is recorded, and how far two recordings of it are apart."""

from dataclasses import dataclass

import numpy as np

from tests.hidden_world.rigs.images import Images, displacement, images
from tests.hidden_world.rigs.motion import Motion, move
from tests.hidden_world.rigs.moves import Move
from tests.hidden_world.rigs.rig import Effect, Rig, Values
from tests.hidden_world.rigs.sensors import acceleration, encoder

LEAST_PX, LEAST_S = 0.02, 20e-6
LEAST_OF_NOISE, LEAST_OF_VARIATION = 0.5, 1.0 / 2000.0
"""When a rest matters, by the contract."""
_LOST_MATTER = 0.01


@dataclass(frozen=True)
class Recording:
    """acceleration, position, speed: a value a cycle, or None where there is no such sensor; px: a value an image."""

    rig: Rig
    motion: Motion
    images: Images
    acceleration: Values | None
    position: Values | None
    speed: Values | None
    px: Values


@dataclass(frozen=True)
class Departure:
    """Of a channel: rms of the change, in its unit, and over the channel's noise; whether that matters by the contract."""

    rms: float
    of_noise: float
    matters: bool


def record(
    rig: Rig,
    moves: list[Move],
    effects: tuple[Effect, ...] = (),
    noise: bool = True,
    motion: Motion | None = None,
    nuisance: bool = True,
) -> Recording:
    """motion: of the same arm, to save the time of computing it again."""
    motion = motion or move(rig, moves, effects, nuisance)
    seen = images(rig, effects)
    felt = acceleration(rig, motion, effects, noise) if rig.accelerometer else None
    position, speed = encoder(rig, motion, noise) if rig.encoder else (None, None)
    return Recording(
        rig, motion, seen, felt, position, speed, displacement(rig, motion, seen, effects, noise)
    )


def departures(changed: Recording, plain: Recording) -> dict[str, Departure]:
    """What an effect does to each channel: both noise-free, of the same rig. Nothing is refitted."""
    rig, out = changed.rig, {}
    if rig.accelerometer:
        out["acceleration"] = _apart(changed.acceleration, plain.acceleration, rig.accelerometer.noise_m_s2)
    if rig.encoder:
        noise = max(rig.encoder.noise_rad, rig.encoder.quantum_rad / np.sqrt(12.0))
        out["joint_position"] = _apart(changed.position, plain.position, noise)
        out["joint_velocity"] = _apart(changed.speed, plain.speed, rig.encoder.speed_noise_rad_s)
    a, b = changed.images, plain.images
    _, here, there = np.intersect1d(a.index, b.index, return_indices=True)
    out["displacement"] = _apart(changed.px[here], plain.px[there], rig.camera.noise_px, LEAST_PX)
    late = (a.received_s - a.middle_s)[here], (b.received_s - b.middle_s)[there]
    out["image_timing"] = _apart(*late, rig.arrival.std_s, LEAST_S)
    if rig.camera.stamped:
        stamp = (a.stamp_s - a.middle_s)[here], (b.stamp_s - b.middle_s)[there]
        noise = max(rig.camera.stamp_jitter_s, rig.camera.stamp_quantum_s / np.sqrt(12.0))
        out["stamp"] = _apart(*stamp, noise, LEAST_S)
    lost = 1.0 - len(a.index) / max(len(b.index), 1)
    if lost > 2e-3:
        out["lost"] = Departure(lost, lost / 1e-3, lost > _LOST_MATTER)
    return out


def _apart(a: Values | None, b: Values | None, noise: float, least: float = 0.0) -> Departure:
    assert a is not None and b is not None
    rms = float(np.sqrt(np.mean((a - b) ** 2)))
    least = max(LEAST_OF_NOISE * noise, LEAST_OF_VARIATION * float(np.std(b)), least)
    return Departure(rms, rms / noise, bool(rms > least))


def largest(all_of: dict[str, Departure]) -> float:
    """Of the noise, in the channel that changes most."""
    return max(d.of_noise for d in all_of.values())
