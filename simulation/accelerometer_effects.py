"""The causes that sit in the accelerometer: what drifts, leaks, hums and crackles before noise and quantisation."""

from math import pi, sin

import numpy as np

from common.causes import CAUSES
from common.effects import Values, effect_of, effects_of
from common.model import Model

IMPULSE_STREAM = 3  # of the seed's random streams


class AccelerometerEffects:
    """a becomes a scale of (1 + drift t), plus bias drift, leaked gravity, hum and impulses."""

    def __init__(self, model: Model, cycle_s: float, seed: int) -> None:
        """As the model's effects name them; the impulses' instants and signs come from the seed."""
        bias, sensitivity = (
            effect_of(model, "accelerometer_bias_drift"),
            effect_of(model, "accelerometer_sensitivity_drift"),
        )
        gravity = effect_of(model, "gravity_leakage")
        self._bias_rate = bias["rate_m_s3"] if bias else 0.0
        self._sensitivity_rate = sensitivity["rate_per_s"] if sensitivity else 0.0
        self._gravity = gravity["gain_m_s2_per_rad"] if gravity else 0.0
        self._hums = [
            (2.0 * pi * hum["frequency_hz"], hum["amplitude_m_s2"], hum["phase_rad"])
            for hum in effects_of(model, "mains_hum")
        ]
        self._impulses = [
            _Impulses(impulses, cycle_s, np.random.default_rng((seed, IMPULSE_STREAM, number)))
            for number, impulses in enumerate(effects_of(model, "impulse_noise"))
        ]

    def sensitivity(self, time_s: float) -> float:
        """By which the scale is to be multiplied, at a time from the recording's start."""
        return 1.0 + self._sensitivity_rate * time_s

    def added_m_s2(self, time_s: float, tip_angle_rad: float) -> float:
        """What is added to a sample, at a time from the recording's start. Once for each sample."""
        added: float = self._bias_rate * time_s + self._gravity * tip_angle_rad
        for w, amplitude, phase in self._hums:
            added += amplitude * sin(w * time_s + phase)
        for impulses in self._impulses:
            added += impulses.sample()
        return added


def accelerometer_effects(model: Model, cycle_s: float, seed: int) -> AccelerometerEffects | None:
    """Those of a model; None where it names none, which saves a microsecond a sample."""
    named = any(CAUSES[str(effect["cause"])].place == "accelerometer" for effect in model.effects)
    return AccelerometerEffects(model, cycle_s, seed) if named else None


class _Impulses:
    """Poisson instants; the sample at or after each takes +-amplitude."""

    def __init__(self, values: Values, cycle_s: float, generator: np.random.Generator) -> None:
        self._rate_hz: float = values["rate_hz"]
        self._amplitude: float = values["amplitude_m_s2"]
        self._cycle_s = cycle_s
        self._generator = generator
        self._left_s = self._gap()

    def sample(self) -> float:
        self._left_s -= self._cycle_s
        total = 0.0
        while self._left_s <= 0.0:
            total += self._amplitude if self._generator.random() < 0.5 else -self._amplitude
            self._left_s += self._gap()
        return total

    def _gap(self) -> float:
        return float(self._generator.exponential(1.0 / self._rate_hz)) if self._rate_hz else float("inf")
