"""How far an effect takes a recording from what the rig would have recorded without it, and whether that matters."""

from dataclasses import dataclass

import numpy as np

from tests.hidden_world.rigs.moves import Move
from tests.hidden_world.rigs.recording import Recording
from tests.hidden_world.rigs.refit import taken_up
from tests.hidden_world.rigs.rig import Values

LEAST_PX, LEAST_S = 0.02, 20e-6
LEAST_OF_NOISE, LEAST_OF_VARIATION = 0.5, 1.0 / 2000.0
"""When a rest matters, by the contract."""
_LOST_MATTER, _LOST_NOISE = 0.01, 0.001
_LOST_ANYWAY = 2e-3


@dataclass(frozen=True)
class Departure:
    """Of a channel: rms of the change in its unit, over the channel's noise, and over what matters by the contract."""

    rms: float
    of_noise: float
    of_what_matters: float

    @property
    def matters(self) -> bool:
        return self.of_what_matters > 1.0


def departures(changed: Recording, plain: Recording, moves: list[Move] | None = None) -> dict[str, Departure]:
    """What an effect does to each channel: both recordings noise-free, of the same rig.

    moves: what was done; then a baseline's own parameters are refitted first (refit.py), and mean delay, the stamps'
    offset and rate taken off. None: nothing is refitted.
    """
    rig, out = changed.rig, {}
    a, b = changed.images, plain.images
    _, here, there = np.intersect1d(a.index, b.index, return_indices=True)
    felt, px = plain.acceleration, plain.px[there]
    if moves is not None:
        felt, px = taken_up(changed, plain, moves)
    if rig.accelerometer:
        out["acceleration"] = _apart(changed.acceleration, felt, rig.accelerometer.noise_m_s2)
    if rig.encoder:
        noise = max(rig.encoder.noise_rad, rig.encoder.quantum_rad / np.sqrt(12.0))
        out["joint_position"] = _apart(changed.position, plain.position, noise)
        out["joint_velocity"] = _apart(changed.speed, plain.speed, rig.encoder.speed_noise_rad_s)
    out["displacement"] = _apart(changed.px[here], px, rig.camera.noise_px, LEAST_PX)
    # nobody knows when an exposure was, but by its number and the request
    late, usual = (a.received_s - a.counted_s)[here], (b.received_s - b.counted_s)[there]
    if moves is not None:
        usual = usual + np.mean(late - usual)
    out["image_timing"] = _apart(late, usual, rig.arrival.std_s, LEAST_S)
    if rig.camera.stamped:
        stamp, without = (a.stamp_s - a.counted_s)[here], (b.stamp_s - b.counted_s)[there]
        if moves is not None:
            t = b.middle_s[there]
            without = without + np.polyval(np.polyfit(t, stamp - without, 1), t)
        noise = max(rig.camera.stamp_jitter_s, rig.camera.stamp_quantum_s / np.sqrt(12.0))
        out["stamp"] = _apart(stamp, without, noise, LEAST_S)
    lost = 1.0 - len(a.index) / max(len(b.index), 1)
    if lost > _LOST_ANYWAY:
        out["lost"] = Departure(lost, lost / _LOST_NOISE, lost / _LOST_MATTER)
    return out


def _apart(a: Values | None, b: Values | None, noise: float, least: float = 0.0) -> Departure:
    assert a is not None and b is not None
    rms = float(np.sqrt(np.mean((a - b) ** 2)))
    least = max(LEAST_OF_NOISE * noise, LEAST_OF_VARIATION * float(np.std(b)), least)
    return Departure(rms, float(rms / noise), float(rms / least))


def clearness(all_of: dict[str, Departure]) -> float:
    """How clearly an effect matters: over half of what matters, in the clearest channel, so that 1 is a channel's
    noise where no other threshold is above half of it."""
    return max(0.5 * d.of_what_matters for d in all_of.values())


def of_noise(all_of: dict[str, Departure]) -> float:
    """Over the noise, in the channel that changes most."""
    return max(d.of_noise for d in all_of.values())
