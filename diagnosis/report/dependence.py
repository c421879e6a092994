"""What a residual's mean depends on: bins of a variable against chance.

Whether the mean of a residual depends on a variable is judged by the share of its variance that bins of the variable
explain, against the same share with the signs of whole blocks of time drawn at random (wild block bootstrap), which
leaves the residual's colour and its changing level as they are.
"""

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.channels import FRAME_CHANNELS
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.physics.world import World

Array = NDArray[np.float64]

_BINS, _TIME_BINS = 12, 6
_DRAWS, _SEED = 1999, 20240229
_SHORTEST_BLOCK_S, _FEWEST_BLOCKS, _MOST_BLOCKS = 0.25, 20, 200
_CHANCE, _LEAST_SHARE = 0.01, 0.003
MOVING = 1e-9


@dataclass(frozen=True)
class Dependence:
    """How the residual's mean follows a variable. centres, means, errors: per bin; share: of the residual's variance.

    chance: how often as large a share comes about without any dependence. significant: over all variables tried.
    """

    variable: str
    unit: str
    centres: Array
    means: Array
    errors: Array
    share: float
    chance: float
    significant: bool


def variables(last: Fit, name: str) -> dict[str, tuple[Array, str]]:
    """What a residual may depend on, at each of the channel's samples: values and unit."""
    world, motion = last.world, last.predicted.motion
    grid = world.cycle_times
    w = 2.0 * pi * last.value("modes.0.frequency_hz")
    q = motion.q[:, 0]
    rate = np.gradient(q) / world.measured.cycle_s
    found = {
        "deflection": (q, "m"),
        "amplitude of the vibration": (np.hypot(q, rate / w), "m"),
        "speed of the deflection": (rate, "m/s"),
        "phase of the vibration": (np.arctan2(-rate / w, q), "rad"),
        "time": (grid, "s"),
    }
    if world.measured.pair:
        found["input"] = (world.measured.force, "")
    else:
        reference, word = external_reference(world)
        found |= {
            "joint position": (motion.joint[:, 0], "rad"),
            "joint velocity": (motion.joint[:, 1], "rad/s"),
            "sign of the joint velocity": (np.sign(np.round(motion.joint[:, 1], 4)), ""),
            "joint acceleration": (motion.joint[:, 2], "rad/s^2"),
            word: (reference, "rad/s"),
        }
    if name in FRAME_CHANNELS:
        at = world.instants(last.vector)
        found = {key: (_at(at, grid, values, key), unit) for key, (values, unit) in found.items()}
        if len(last.predicted.rate_px_s):
            found["speed of the image"] = (last.predicted.rate_px_s, "px/s")
    elif len(world.measured.frames) > 1:
        received = np.sort(world.measured.frames.received_s)
        before = np.searchsorted(received, grid, side="right") - 1
        since = np.where(before >= 0, grid - received[np.maximum(before, 0)], np.nan)
        found["time since the last frame"] = (since, "s")
    return found


def _at(instants: Array, grid: Array, values: Array, key: str) -> Array:
    if key.startswith(("phase", "sign")):  # no interpolation across a jump
        return values[np.clip(np.searchsorted(grid, instants), 0, len(grid) - 1)]
    return np.interp(instants, grid, values)


def external_reference(world: World) -> tuple[Array, str]:
    """What the command was made from: in closed loop the external reference, which noise does not come back into."""
    reference, command = np.nan_to_num(world.measured.reference), np.nan_to_num(world.measured.command)
    if closed_loop(world):
        return reference, "external reference"
    return command, "command"


def closed_loop(world: World) -> bool:
    """Whether the command held more than the external reference, so that the noise came back into it."""
    reference, command = world.measured.reference, world.measured.command
    both = np.isfinite(reference) & np.isfinite(command)
    return bool(both.any() and np.max(np.abs(reference[both] - command[both])) > MOVING)


def dependences_of(residual: Array, against: dict[str, tuple[Array, str]], time_s: Array) -> list[Dependence]:
    """How the residual's mean follows each variable, the strongest first. All arrays: one value a sample."""
    known = np.isfinite(residual)
    if known.sum() < 100:
        return []
    e = residual[known] - np.mean(residual[known])
    limit = 6.0 * float(np.std(e))
    e = np.clip(e, -limit, limit)
    block, blocks = _blocks(e, time_s[known])
    signs = np.where(np.random.default_rng(_SEED).random((_DRAWS, blocks)) < 0.5, -1.0, 1.0)
    found = []
    for variable, (values, unit) in against.items():
        one = _dependence(e, values[known], block, signs, variable, unit)
        if one is not None:
            found.append(one)
    most = _CHANCE / max(len(found), 1)
    judged = [
        Dependence(
            **{
                **one.__dict__,
                "significant": one.chance <= max(most, 1.0 / (_DRAWS + 1)) and one.share > _LEAST_SHARE,
            }
        )
        for one in found
    ]
    return sorted(judged, key=lambda one: (not one.significant, -one.share))


def _blocks(e: Array, time_s: Array) -> tuple[NDArray[np.int64], int]:
    """Blocks of time longer than the residual remembers."""
    duration = float(time_s[-1] - time_s[0])
    n = len(e)
    size = 1 << (2 * n - 1).bit_length()
    memory = np.fft.irfft(np.abs(np.fft.rfft(e, size)) ** 2, size)[: max(n // 10, 2)]
    over = np.flatnonzero(np.abs(memory) > 0.2 * memory[0])
    remembers = 2.0 * float(over[-1] + 1) * duration / n if len(over) else 0.0
    length = max(remembers, _SHORTEST_BLOCK_S)
    count = int(np.clip(duration / length, _FEWEST_BLOCKS, _MOST_BLOCKS))
    block = np.clip(((time_s - time_s[0]) / max(duration, 1e-9) * count).astype(np.int64), 0, count - 1)
    return block, count


def _dependence(
    e: Array, x: Array, block: NDArray[np.int64], signs: Array, variable: str, unit: str
) -> Dependence | None:
    good = np.isfinite(x)
    if good.sum() < 100 or float(np.ptp(x[good])) <= 1e-12:
        return None
    e, x, block = e[good], x[good], block[good]
    distinct = np.unique(x)
    if len(distinct) <= _BINS:
        edges = 0.5 * (distinct[1:] + distinct[:-1])
    else:
        bins = _TIME_BINS if variable == "time" else _BINS
        edges = np.unique(np.quantile(x, np.linspace(0.0, 1.0, bins + 1)[1:-1]))
    place = np.searchsorted(edges, x)
    count = len(edges) + 1
    blocks = signs.shape[1]
    sums = np.bincount(block * count + place, e, blocks * count).reshape(blocks, count)
    held = np.bincount(place, minlength=count).astype(float)
    keep = held >= 20
    if keep.sum() < 2:
        return None
    sums, held = sums[:, keep], held[keep]
    total = float(e @ e) or 1.0

    def share(of: Array) -> Array:
        result: Array = np.sum(of**2 / held, axis=-1) / total
        return result

    mine = float(share(sums.sum(axis=0)))
    drawn = share(signs @ sums)
    centres = (np.bincount(place, x, count) / np.maximum(np.bincount(place, minlength=count), 1))[keep]
    means = sums.sum(axis=0) / held
    errors = np.sqrt(np.sum(sums**2, axis=0)) / held
    chance = (1.0 + float(np.sum(drawn >= mine))) / (1.0 + len(drawn))
    return Dependence(
        variable, unit, centres, means, errors, max(mine - float(np.mean(drawn)), 0.0), chance, False
    )
