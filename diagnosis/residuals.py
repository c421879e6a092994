"""What a channel's residual shows: its spectrum on the noise floor, what it depends on, and tests, in words for people.

Whether the mean of a residual depends on a variable is judged by the share of its variance that bins of the variable
explain, against the same share with the signs of whole blocks of time drawn at random (wild block bootstrap), which
leaves the residual's colour and its changing level as they are.
"""

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

from stillarm.diagnosis.channels import FRAME_CHANNELS
from stillarm.diagnosis.fit import Fit
from stillarm.diagnosis.residual_tests import (
    Correlation,
    autocorrelation,
    crosscorrelation,
    square_correlation,
)
from stillarm.diagnosis.robust import std_about_median
from stillarm.diagnosis.world import World

Array = NDArray[np.float64]

UNITS = {
    "acceleration": "m/s^2",
    "joint_position": "rad",
    "joint_velocity": "rad/s",
    "deflection": "m",
    "displacement": "px",
    "arrival": "s",
}
_BINS, _TIME_BINS = 12, 6
_DRAWS, _SEED = 1999, 20240229
_SHORTEST_BLOCK_S, _FEWEST_BLOCKS, _MOST_BLOCKS = 0.25, 20, 200
_CHANCE, _LEAST_SHARE = 0.01, 0.003
_LAGS = 60
_OVER_FLOOR = 3.0
_MOVING = 1e-9


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


@dataclass(frozen=True)
class Tested:
    """A correlation test with its sentence. name: what against what."""

    name: str
    correlation: Correlation
    step_s: float
    sentence: str


@dataclass(frozen=True)
class Spectrum:
    """One-sided power density, unit^2/Hz, and the level that white noise of the floor's deviation has."""

    hz: Array
    density: Array
    floor: float


@dataclass(frozen=True)
class ChannelResidual:
    """A channel's residual, measured less predicted, in the channel's unit, and what was found in it."""

    channel: str
    unit: str
    time_s: Array
    values: Array
    spectrum: Spectrum
    dependences: list[Dependence]
    tests: list[Tested]
    sentences: list[str]


def residual_of(last: Fit, name: str) -> Array:
    """Measured less predicted, NaN where unmeasured."""
    found: Array = last.world.channels[name] - last.predicted.channels[name]
    return found


def times_of(world: World, name: str) -> Array:
    """Time of each sample, s from the first cycle: when it was read."""
    return world.measured.frames.received_s if name in FRAME_CHANNELS else world.cycle_times


def noise_floor(values: Array) -> float:
    """Deviation of the noise from neighbouring samples: what no model of slow things can go below."""
    steps = np.diff(values[np.isfinite(values)])
    return std_about_median(steps) / float(np.sqrt(2.0)) if len(steps) else 0.0


def examine_channel(last: Fit, name: str) -> ChannelResidual:
    """Everything about one channel's residual in a fit."""
    world = last.world
    values, white = residual_of(last, name), last.residuals[name]
    time = times_of(world, name)
    spectrum = spectrum_of(values, world.step_s(name))
    dependences = dependences_of(white, variables(last, name), time)
    tests = _tests(last, name, white)
    loud = [one.sentence for one in tests if one.correlation.significant]
    quiet = [one.name for one in tests if not one.correlation.significant]
    sentences = [_about_spectrum(spectrum), _about_dependences(dependences), *loud]
    if quiet:
        sentences.append(f"Within its band: {', '.join(quiet)}.")
    return ChannelResidual(name, UNITS[name], time, values, spectrum, dependences, tests, sentences)


def spectrum_of(values: Array, step_s: float) -> Spectrum:
    """Welch's estimate, 8 pieces or more where there are enough samples; missing samples count as zero."""
    known = np.isfinite(values)
    whole = np.where(known, values - (np.mean(values[known]) if known.any() else 0.0), 0.0)
    length = int(min(len(whole), max(64, 2 ** int(np.log2(max(len(whole) / 4, 64))))))
    hz, density = welch(whole, 1.0 / step_s, nperseg=length)
    floor = 2.0 * noise_floor(values) ** 2 * step_s
    return Spectrum(hz[1:], density[1:], floor)


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
        reference, word = _external(world)
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


def _external(world: World) -> tuple[Array, str]:
    """What the command was made from: in closed loop the external reference, which noise does not come back into."""
    reference, command = np.nan_to_num(world.measured.reference), np.nan_to_num(world.measured.command)
    if closed_loop(world):
        return reference, "external reference"
    return command, "command"


def closed_loop(world: World) -> bool:
    """Whether the command held more than the external reference, so that the noise came back into it."""
    reference, command = world.measured.reference, world.measured.command
    both = np.isfinite(reference) & np.isfinite(command)
    return bool(both.any() and np.max(np.abs(reference[both] - command[both])) > _MOVING)


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


def _tests(last: Fit, name: str, white: Array) -> list[Tested]:
    """Whiteness, and independence of the input and of the simulated swing, to first and second order."""
    world = last.world
    step = world.step_s(name)
    n = len(white)
    reach = 2.0 / last.value("modes.0.frequency_hz")
    far = max(min(int(reach / step), n // 10), 4)
    lags = np.unique(np.linspace(0, far, min(_LAGS, far) + 1).astype(np.int64))
    near = np.arange(1, min(25, max(n // 10, 2)))
    own = autocorrelation(white, near)
    found = [Tested("residual with its own past", own, step, _about_memory(own, step))]
    for word, values in _drivers(last, name).items():
        first = crosscorrelation(white, values, lags)
        second = square_correlation(white, values, lags)
        found.append(Tested(f"residual with the {word}", first, step, _about_first(first, word, step)))
        found.append(
            Tested(
                f"its square with the square of the {word}", second, step, _about_second(second, word, step)
            )
        )
    return found


def _drivers(last: Fit, name: str) -> dict[str, Array]:
    """What drove the rig, at the channel's samples."""
    world, grid = last.world, last.world.cycle_times
    if world.measured.pair:
        drivers = {"input": world.measured.force}
    else:
        reference, word = _external(world)
        drivers = {word: reference} if float(np.ptp(reference)) > _MOVING else {}
        drivers["simulated deflection"] = last.predicted.motion.deflection
    if name in FRAME_CHANNELS:
        at = world.instants(last.vector)
        drivers = {word: np.interp(at, grid, values) for word, values in drivers.items()}
    return drivers


def _about_spectrum(spectrum: Spectrum) -> str:
    if spectrum.floor <= 0.0:
        return "The noise floor cannot be told."
    over = spectrum.density / spectrum.floor
    top = int(np.argmax(over))
    if over[top] < _OVER_FLOOR:
        return f"Its spectrum nowhere exceeds the noise floor {_OVER_FLOOR:.0f} times."
    band = spectrum.hz[over > _OVER_FLOOR]
    return (
        f"Its spectrum rises to {over[top]:.3g} times the noise floor at {spectrum.hz[top]:.3g} Hz; "
        f"it exceeds the floor {_OVER_FLOOR:.0f} times between {band[0]:.3g} and {band[-1]:.3g} Hz."
    )


def _about_dependences(found: list[Dependence]) -> str:
    strong = [one for one in found if one.significant]
    if not strong:
        return "It follows none of the variables tried."
    parts = [f"the {one.variable} ({100.0 * one.share:.2g} % of its variance)" for one in strong[:3]]
    return f"It follows {', '.join(parts)}."


def _about_memory(found: Correlation, step_s: float) -> str:
    if not found.significant:
        return "Its samples do not tell of each other: it is white as far as this recording shows."
    k = found.strongest
    late = found.lags[k] * step_s
    return f"It is not white: samples {late:.3g} s apart correlate by {found.values[k]:+.2f}."


def _about_first(found: Correlation, word: str, step_s: float) -> str:
    if not found.significant:
        return f"It does not follow the {word} linearly."
    k = found.strongest
    return (
        f"It follows the {word} of {found.lags[k] * step_s:.3g} s before (correlation {found.values[k]:+.2f}): "
        "something linear, such as a delay, a gain or a mode, is off."
    )


def _about_second(found: Correlation, word: str, step_s: float) -> str:
    if not found.significant:
        return f"It is no larger where the {word} is large."
    k = found.strongest
    more = "grows" if found.values[k] > 0.0 else "shrinks"
    return (
        f"It {more} with the size of the {word} {found.lags[k] * step_s:.3g} s before "
        f"(correlation of the squares {found.values[k]:+.2f}): the model is off by an amount that depends on size."
    )
