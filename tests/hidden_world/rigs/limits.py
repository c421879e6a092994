"""What one who knows all about a case could reach: the error that is left, and how clearly an effect shows."""

import numpy as np
from numpy.typing import NDArray

from tests.hidden_world.rigs.case import Case
from tests.hidden_world.rigs.recording import record
from tests.hidden_world.rigs.rig import TICK_S, Values

_BLOCKS, _SHORTEST_S, _EVERY = 30, 0.8, 3
_LAW_OF_NOISE = "impulse_noise"
"""Its spikes are part of the noise-free recording; no model foretells them."""


def held_out(time_s: Values, duration_s: float) -> NDArray[np.bool_]:
    """Which times lie in every third of thirty blocks, of fewer where they would be shorter than 0.8 s: what a
    diagnosis holds out that is not told what to hold out."""
    count = max(9, min(_BLOCKS, int(duration_s / _SHORTEST_S)))
    count -= count % _EVERY
    return np.asarray(np.floor(time_s / duration_s * count) % _EVERY == 1)


def floor(case: Case) -> dict[str, float]:
    """What the true model leaves of each channel where held out: rms of measured minus noise-free, over the standard
    deviation of what is measured there. The true model knows the nuisance, and when images were exposed."""
    rig, measured = case.rig, case.recording
    clean = record(rig, case.moves, case.effects, False, measured.motion)
    cycles_s = np.arange(rig.cycles) * TICK_S
    both = {
        "acceleration": (cycles_s, measured.acceleration, clean.acceleration),
        "joint_position": (cycles_s, measured.position, clean.position),
        "joint_velocity": (cycles_s, measured.speed, clean.speed),
        "displacement": (measured.images.middle_s, measured.px, clean.px),
    }
    out = {}
    for name, (at_s, noisy, true) in both.items():
        held = held_out(at_s, rig.duration_s)
        if noisy is not None and true is not None and np.sum(held) > 1:
            left = float(np.sqrt(np.mean((noisy - true)[held] ** 2)))
            out[name] = left / float(np.std(noisy[held]))
    return out


def strongest(case: Case) -> str | None:
    """The channel that the effects change most, of what matters; None where nothing is hidden, or a law of noise."""
    if not case.seen or any(effect.cause == _LAW_OF_NOISE for effect in case.effects):
        return None
    return max(case.seen, key=lambda name: case.seen[name].of_what_matters)


def least_nats(case: Case) -> float | None:
    """Expected log-likelihood ratio, at the least, of an oracle that knows the effects over the refitted model without
    them; None where they change no channel for which the bound holds.

    n samples of white noise give n s^2 / 2 nats for a known change of rms s, in units of the noise. Noise of which each
    value is correlated with the next by c has up to (1 + c) / (1 - c) times that power at a frequency, so that much
    less is certain. The channel that gives most counts, alone: the others would add to it. Timing and lost frames
    are left out, as their noise wanders.
    """
    rig, frames = case.rig, len(case.recording.images.index)
    sensor = rig.accelerometer
    samples = {
        "acceleration": (rig.cycles, sensor.colour if sensor else 0.0),
        "joint_position": (rig.cycles, 0.0),
        "joint_velocity": (rig.cycles, 0.0),
        "displacement": (frames, rig.camera.colour),
        "stamp": (frames, 0.0),
    }
    nats = [
        0.5 * count * case.seen[name].of_noise ** 2 * (1.0 - colour) / (1.0 + colour)
        for name, (count, colour) in samples.items()
        if name in case.seen
    ]
    return max(nats, default=0.0) or None
