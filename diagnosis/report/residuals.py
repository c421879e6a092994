"""What a channel's residual shows: its spectrum on the noise floor, what it depends on, tests, in words for people."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

from stillarm.diagnosis.data.channels import FRAME_CHANNELS
from stillarm.diagnosis.data.robust import std_about_median
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.report.dependence import (
    MOVING,
    Dependence,
    dependences_of,
    external_reference,
    variables,
)
from stillarm.diagnosis.report.residual_tests import (
    Correlation,
    autocorrelation,
    crosscorrelation,
    square_correlation,
)

Array = NDArray[np.float64]

WORDS = {
    "acceleration": "acceleration",
    "joint_position": "joint position",
    "joint_velocity": "joint velocity",
    "deflection": "deflection",
    "displacement": "image displacement",
    "arrival": "arrival of the frames",
}
UNITS = {
    "acceleration": "m/s^2",
    "joint_position": "rad",
    "joint_velocity": "rad/s",
    "deflection": "m",
    "displacement": "px",
    "arrival": "s",
}
_LAGS = 60
_OVER_FLOOR = 3.0


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


def noise_floor(values: Array) -> float:
    """Deviation of the noise from neighbouring samples: what no model of slow things can go below."""
    steps = np.diff(values[np.isfinite(values)])
    return std_about_median(steps) / float(np.sqrt(2.0)) if len(steps) else 0.0


def examine_channel(last: Fit, name: str) -> ChannelResidual:
    """Everything about one channel's residual in a fit."""
    world = last.world
    values, white = residual_of(last, name), last.residuals[name]
    time = world.times_of(name)
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
        reference, word = external_reference(world)
        drivers = {word: reference} if float(np.ptp(reference)) > MOVING else {}
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
