"""The causes that sit in the accelerometer: what drifts, leaks, hums and crackles before noise and quantisation."""

from math import prod

import numpy as np

from stillarm.common.causes import CAUSES
from stillarm.common.files.effects import Values, effects_of, laws_at
from stillarm.common.files.model import Model

IMPULSE_STREAM = 3  # of the seed's random streams


class AccelerometerEffects:
    """What the laws of sensitivity, reading and impulse in a model make of an acceleration."""

    def __init__(self, model: Model, cycle_s: float, seed: int) -> None:
        """As the model's effects name them; the impulses' instants and signs come from the seed."""
        self._sensitivities = laws_at(model, "sensitivity")
        self._readings = laws_at(model, "reading")
        crackling = [
            (cause.identifier, values)
            for cause in CAUSES.values()
            if cause.acts == "impulse"
            for values in effects_of(model, cause.identifier)
        ]
        self._impulses = [
            _Impulses(identifier, values, cycle_s, np.random.default_rng((seed, IMPULSE_STREAM, number)))
            for number, (identifier, values) in enumerate(crackling)
        ]

    def sensitivity(self, time_s: float) -> float:
        """Factor for the scale, at a time from the recording's start."""
        return float(prod(law(time_s) for law in self._sensitivities))

    def added_m_s2(self, time_s: float, tip_angle_rad: float) -> float:
        """Addition to a sample, m/s^2, at a time from the recording's start. To be called once for each sample."""
        added = sum(law(time_s, tip_angle_rad) for law in self._readings)
        return float(added + sum(impulses.sample() for impulses in self._impulses))


def accelerometer_effects(model: Model, cycle_s: float, seed: int) -> AccelerometerEffects | None:
    """Those of a model; None where it names none, which saves a microsecond a sample."""
    named = any(CAUSES[str(effect["cause"])].place == "accelerometer" for effect in model.effects)
    return AccelerometerEffects(model, cycle_s, seed) if named else None


class _Impulses:
    """Poisson instants at the effect's rate_hz; the sample at or after each takes what the law says, of random sign."""

    def __init__(
        self, identifier: str, values: Values, cycle_s: float, generator: np.random.Generator
    ) -> None:
        cause = CAUSES[identifier]
        assert cause.law is not None
        own = cause.arguments(values)
        self._up, self._down = (float(cause.law(sign, *own)) for sign in (1.0, -1.0))
        self._rate_hz: float = values["rate_hz"]
        self._cycle_s = cycle_s
        self._generator = generator
        self._left_s = self._gap()

    def sample(self) -> float:
        self._left_s -= self._cycle_s
        total = 0.0
        while self._left_s <= 0.0:
            total += self._up if self._generator.random() < 0.5 else self._down
            self._left_s += self._gap()
        return total

    def _gap(self) -> float:
        return float(self._generator.exponential(1.0 / self._rate_hz)) if self._rate_hz else float("inf")
