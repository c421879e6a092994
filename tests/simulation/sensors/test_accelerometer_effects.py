"""The accelerometer's causes against plain formulas."""

from math import pi
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from stillarm.common.files.effects import declared
from stillarm.common.files.model import Accelerometer, Model
from stillarm.simulation.sensors.accelerometer_effects import AccelerometerEffects
from stillarm.simulation.sensors.accelerometer_signal import AccelerometerSignal

CYCLE_S = 0.001
TIMES = np.arange(4000) * CYCLE_S
TRUE = 2.0 * np.cos(2.0 * pi * 2.6 * TIMES)
ANGLE = 0.1 * np.sin(2.0 * pi * 0.4 * TIMES)


def sensed(*effects: dict[str, Any], seed: int = 0, noise: float = 0.0) -> NDArray[np.float64]:
    accelerometer = Accelerometer(noise_std_m_s2=noise, scale=-1.5, bias_m_s2=0.2)
    model = declared(Model(accelerometer=accelerometer, effects=list(effects)))
    added = AccelerometerEffects(model, CYCLE_S, seed)
    sensor = AccelerometerSignal(model.accelerometer, CYCLE_S, np.random.default_rng(seed), added)
    rows = zip(TRUE.tolist(), TIMES.tolist(), ANGLE.tolist(), strict=True)
    return np.array([sensor.sample(true, time, angle) for true, time, angle in rows])


PLAIN = -1.5 * TRUE + 0.2


@pytest.mark.parametrize(
    ("effect", "wanted"),
    [
        ({"cause": "accelerometer_bias_drift", "rate_m_s3": -0.04}, PLAIN - 0.04 * TIMES),
        (
            {"cause": "accelerometer_sensitivity_drift", "rate_per_s": 0.1},
            -1.5 * (1.0 + 0.1 * TIMES) * TRUE + 0.2,
        ),
        ({"cause": "gravity_leakage", "gain_m_s2_per_rad": 9.0}, PLAIN + 9.0 * ANGLE),
        (
            {"cause": "mains_hum", "frequency_hz": 50.0, "amplitude_m_s2": 0.5, "phase_rad": 0.3},
            PLAIN + 0.5 * np.sin(2.0 * pi * 50.0 * TIMES + 0.3),
        ),
        ({"cause": "accelerometer_clipping", "range_m_s2": 1.3}, np.clip(PLAIN, -1.3, 1.3)),
    ],
)
def test_each_is_what_the_catalogue_says(effect: dict[str, Any], wanted: NDArray[np.float64]) -> None:
    assert sensed(effect) == pytest.approx(wanted, abs=1e-12)


def test_a_lag_shifts_the_signal() -> None:
    found = sensed({"cause": "accelerometer_lag", "delay_s": 0.0125})
    wanted = -1.5 * 2.0 * np.cos(2.0 * pi * 2.6 * (TIMES - 0.0125)) + 0.2
    assert found[30:] == pytest.approx(wanted[30:], abs=1e-6)


@pytest.mark.slow
def test_impulses_are_single_poisson_and_of_either_sign() -> None:
    """Count, spacing and signs over 400 runs of four seconds, as a Poisson process has them."""
    effect = {"cause": "impulse_noise", "rate_hz": 2.0, "amplitude_m_s2": 8.0}
    counts, gaps, ups = [], [], 0
    for seed in range(400):
        model = Model(effects=[effect])  # type: ignore[list-item]
        effects = AccelerometerEffects(model, CYCLE_S, seed)
        added = np.array([effects.added_m_s2(t, 0.0) for t in TIMES.tolist()])
        assert set(np.round(added[added != 0.0], 9)) <= {8.0, -8.0, 16.0, -16.0}
        at = np.flatnonzero(added)
        counts.append(len(at))
        gaps += np.diff(at).tolist()
        ups += int(np.sum(added > 0.0))
    total = sum(counts)
    assert np.mean(counts) == pytest.approx(8.0, abs=4.0 * (8.0 / 400) ** 0.5)
    assert np.var(counts) == pytest.approx(8.0, rel=0.3)
    assert ups / total == pytest.approx(0.5, abs=4.0 * 0.5 / total**0.5)
    short = float(np.mean(np.array(gaps) < 100))
    # of two instants within one run, uniform over 4 s, gaps below 0.1 s: about 1 - exp(-0.2), a little more
    assert 0.15 < short < 0.25
    assert np.array_equal(sensed(effect, seed=3), sensed(effect, seed=3))
    assert not np.array_equal(sensed(effect, seed=3), sensed(effect, seed=4))


def test_effects_leave_the_noise_alone_and_no_size_is_no_effect() -> None:
    """The same noise with and without; to the bit at size zero."""
    plain = sensed(noise=0.5)
    none: list[dict[str, Any]] = [
        {"cause": "accelerometer_bias_drift", "rate_m_s3": 0.0},
        {"cause": "accelerometer_sensitivity_drift", "rate_per_s": 0.0},
        {"cause": "gravity_leakage", "gain_m_s2_per_rad": 0.0},
        {"cause": "mains_hum", "frequency_hz": 50.0, "amplitude_m_s2": 0.0},
        {"cause": "impulse_noise", "rate_hz": 0.0, "amplitude_m_s2": 5.0},
        {"cause": "accelerometer_lag", "delay_s": 0.0},
    ]
    assert np.array_equal(sensed(*none, noise=0.5), plain)
    drifting = sensed({"cause": "accelerometer_bias_drift", "rate_m_s3": 0.5}, noise=0.5)
    assert drifting - plain == pytest.approx(0.5 * TIMES, abs=1e-12)
