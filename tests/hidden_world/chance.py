"""How clearly a random effect shows to one who knows its law, and not the course that it happened to take.

A law is the spectrum, as it changes with time, of what the effect adds to each whitened channel beside a refitted
baseline: the mean over courses drawn anew under the same manoeuvres. Against white noise of one level, learnt from
the data too, the expected log-likelihood ratio of the cells of a short-time Fourier transform, n numbers with
variance 1 + K in each, is sum n (ln v - ln(1 + K)) / 2, v the mean of 1 + K; K from M courses scatters, which adds
K^2 / (2 M (1 + K)^2) to each cell by mere chance, and is taken off. Each channel by the length of window that tells
most; what channels have in common is not counted. So more noise of the same colour is worth nothing.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tests.hidden_world.effects import Effect
from tests.hidden_world.feeler import burst_times
from tests.hidden_world.rig import TICK_S

Array = NDArray[np.float64]

RANDOM = ("gusts", "correlated_bursts", "aliased_gear_mesh", "second_axis", "wandering_gain")
"""Effects whose course nobody can foretell, and which add in proportion to their amount. The gear mesh is one: the
phase of its teeth turns once while the joint moves by what its encoder leaves open."""

_COURSES = 8
_WINDOWS_S = (0.5, 2.0, 8.0, float("inf"))
_BAND = 0.04
_PLACING_NATS = 5.0


@dataclass(frozen=True)
class Cells:
    """One channel seen through one window. count: numbers in each cell; power: K at an amount of one."""

    count: Array
    power: Array

    def nats(self, amount: float) -> float:
        """Of the law at this amount against white noise."""
        extra = amount * amount * self.power
        variance = 1.0 + extra
        level = float(np.sum(self.count * variance) / np.sum(self.count))
        chance = float(np.sum((extra / variance) ** 2)) / (2.0 * _COURSES)
        return 0.5 * float(np.sum(self.count * (np.log(level) - np.log(variance)))) - chance


@dataclass(frozen=True)
class Law:
    """Every channel through every window."""

    channels: tuple[tuple[Cells, ...], ...]

    def nats(self, amount: float) -> float:
        """Each channel by its best window."""
        return sum(max(0.0, *(one.nats(amount) for one in windows)) for windows in self.channels)


def other_course(effect: Effect, number: int) -> Effect:
    """The same effect by other luck."""
    random = np.random.default_rng((effect.luck, 91, number))
    other = replace(effect, luck=int(random.integers(2**31)))
    if effect.name == "aliased_gear_mesh":
        other = other.with_value("teeth_per_rad", effect["teeth_per_rad"] * float(random.uniform(0.95, 1.05)))
    return other


def law_of(effect: Effect, shown: Callable[[Effect], dict[str, tuple[float, Array]]]) -> Law:
    """The law by example. shown: each channel's samples a second, and what an effect leaves of it, whitened."""
    courses = [shown(other_course(effect, k)) for k in range(_COURSES)]
    out = []
    for name in courses[0]:
        rate = courses[0][name][0]
        parts = [course[name][1] / effect["amount"] for course in courses]
        out.append(tuple(cells(parts, rate, window) for window in _WINDOWS_S))
    return Law(tuple(out))


def cells(parts: list[Array], rate: float, window_s: float) -> Cells:
    """Mean power over courses in each cell: windows side by side, bands of 4 % or a line where that is more."""
    size = len(parts[0])
    length = max(min(round(min(window_s, 1e6) * rate), size), 1)
    windows = size // length
    numbers = np.full(length // 2 + 1, 2.0)
    numbers[0] = 1.0
    if length % 2 == 0:
        numbers[-1] = 1.0
    starts = [0]
    while (following := max(starts[-1] + 1, int(starts[-1] * (1.0 + _BAND)))) < len(numbers):
        starts.append(following)
    power = np.zeros((windows, len(starts)))
    for part in parts:
        cut = part[: windows * length].reshape(windows, length)
        lines = np.abs(np.fft.rfft(cut, axis=1, norm="ortho")) ** 2
        power += np.add.reduceat(numbers * lines, starts, axis=1) / len(parts)
    count = np.add.reduceat(numbers, starts)
    return Cells(np.broadcast_to(count, power.shape), power / count)


def burst_nats(effect: Effect, hiss: float, noise: float, duration_s: float) -> float:
    """correlated_bursts by their own law: white noise, and in bursts that have to be placed coloured noise besides.

    The level of white noise alone is learnt: (N ln v - sum over bursts and frequencies of ln(1 + k)) / 2.
    """
    ticks = round(duration_s / TICK_S)
    spectrum = burst_spectrum()
    total, logs, bursts = 0.0, 0.0, 0
    for _, lasts, size in burst_times(effect, duration_s):
        k = (effect["amount"] * size * hiss / noise) ** 2 * spectrum
        samples = lasts / TICK_S
        total += samples * float(np.mean(k))
        logs += samples * float(np.mean(np.log1p(k)))
        bursts += 1
    return 0.5 * (ticks * float(np.log1p(total / ticks)) - logs) - _PLACING_NATS * bursts


def burst_spectrum() -> Array:
    """Power of the bursts' noise over frequency, mean one: a resonance at 35 Hz of damping 0.1."""
    turn = np.exp(-1j * np.linspace(0.0, np.pi, 4001))
    pole = np.exp(2.0 * np.pi * TICK_S * 35.0 * (-0.1 + 1j))
    power = 1.0 / np.abs(1.0 - 2.0 * pole.real * turn + abs(pole) ** 2 * turn**2) ** 2
    return np.asarray(power / np.mean(power))
