"""The energy test by itself: impacts and noise are no growth; a vibration that the joint feeds is."""

from dataclasses import dataclass
from math import cos, exp, inf, nan, pi, sin

import numpy as np
import pytest

from stillarm.common.files.model import Accelerometer, Arm, Mode, Model
from stillarm.controller.safety.energy import EnergyTest

LENGTH_M = 2.0
A = 0.00625  # m


def model_of(frequency_hz: float = 2.6, noise_std_m_s2: float = 0.5) -> Model:
    mode = Mode(frequency_hz=frequency_hz, participation=1.14, damping_ratio=0.01)
    return Model(
        arm=Arm(length_m=LENGTH_M, modes=[mode]), accelerometer=Accelerometer(noise_std_m_s2=noise_std_m_s2)
    )


@dataclass
class Impact:
    """Adds a velocity of amplitude_m * w at time_s."""

    time_s: float
    amplitude_m: float


def first_alarm_s(
    model: Model,
    duration_s: float,
    *,
    impacts: tuple[Impact, ...] = (),
    growth_per_period: float = 1.0,
    initial_m: float = 0.0,
    seed: int = 0,
    estimate_known: bool = False,
) -> float:
    """When growth is found by the accelerometer of a vibration that the joint's work leaves alone; inf if never."""
    test, h = EnergyTest(model, LENGTH_M), model.timing.cycle_s
    w = model.arm.modes[0].angular_frequency
    grow = exp(np.log(growth_per_period) * w * h / (2.0 * pi))
    turn = complex(cos(w * h), sin(w * h)) * grow
    noise = np.random.default_rng(seed).normal(0.0, model.accelerometer.noise_std_m_s2, round(duration_s / h))
    z, waiting = complex(initial_m), sorted(impacts, key=lambda impact: -impact.time_s)
    for cycle, off in enumerate(noise.tolist()):
        if waiting and waiting[-1].time_s <= cycle * h:
            z += 1j * waiting.pop().amplitude_m
        amplitude = abs(z) if estimate_known else nan
        if test.grows(1, -w * w * z.real + off, 0.0, True, amplitude):
            return cycle * h
        z *= turn
    return inf


@pytest.mark.slow
@pytest.mark.parametrize("apart_periods", [1.5, 2.0, 2.5])
@pytest.mark.parametrize("phase", [0.0, 0.25, 0.5, 0.75])
def test_two_impacts_near_each_other_are_no_growth(apart_periods: float, phase: float) -> None:
    """Each shows in two periods of the accelerometer's amplitude."""
    period_s = 1.0 / 2.6
    first = 2.0 + phase * period_s
    impacts = (Impact(first, A), Impact(first + apart_periods * period_s, 3.0 * A))
    for seed in range(2):
        assert first_alarm_s(model_of(), 6.0, impacts=impacts, initial_m=0.0008, seed=seed) == inf


@pytest.mark.slow
@pytest.mark.parametrize("frequency_hz", [0.3, 2.6])
def test_noise_alone_is_no_growth(frequency_hz: float) -> None:
    """With a rather noisy sensor: for a slow arm its noise equals centimetres of deflection."""
    assert first_alarm_s(model_of(frequency_hz, 2.0), 120.0) == inf


@pytest.mark.parametrize("estimate_known", [False, True])
def test_steady_growth_is_found_within_six_periods(estimate_known: bool) -> None:
    """After an impact, with a growth of 1.4 per period; with and without an estimate."""
    model = model_of()
    found_s = first_alarm_s(
        model, 6.0, impacts=(Impact(1.0, A),), growth_per_period=1.4, estimate_known=estimate_known
    )
    assert 1.0 < found_s <= 1.0 + 6.0 / model.arm.modes[0].frequency_hz
