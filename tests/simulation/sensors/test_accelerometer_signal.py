"""What the simulated accelerometer adds to the true acceleration."""

from math import cos, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stillarm.common.files.model import Accelerometer
from stillarm.simulation.sensors.accelerometer_signal import AccelerometerSignal

CYCLE_S = 0.001


def signal(seed: int = 0, **settings: float) -> AccelerometerSignal:
    return AccelerometerSignal(
        Accelerometer(**{"noise_std_m_s2": 0.0, **settings}), CYCLE_S, np.random.default_rng(seed)
    )


@pytest.mark.parametrize("delay_s", [0.0, 0.0003, 0.0007, 0.001, 0.0015, 0.002, 0.0123])
def test_a_sine_comes_late_by_the_delay(delay_s: float) -> None:
    sensor = signal(delay_s=delay_s)
    w = 2.0 * pi * 2.6
    seen = [sensor.sample(cos(w * n * CYCLE_S)) for n in range(400)]
    expected = [cos(w * (n * CYCLE_S - delay_s)) for n in range(400)]
    assert seen[20:] == pytest.approx(expected[20:], abs=1e-7)


@pytest.mark.parametrize(("delay_s", "cycles"), [(0.0, 0), (0.001, 1), (0.007, 7)])
def test_whole_cycles_of_delay_are_exact(delay_s: float, cycles: int) -> None:
    sensor = signal(delay_s=delay_s)
    values = np.random.default_rng(1).uniform(-5.0, 5.0, 50).tolist()
    seen = [sensor.sample(value) for value in values]
    assert seen == ([0.0] * cycles + values)[:50]


def test_scale_bias_and_range() -> None:
    sensor = signal(scale=-2.0, bias_m_s2=0.5, range_m_s2=10.0)
    assert [sensor.sample(a) for a in (0.0, 1.0, -3.0, 100.0, -100.0)] == [0.5, -1.5, 6.5, -10.0, 10.0]


def test_noise_is_white_of_the_stated_level_and_repeats_from_its_seed() -> None:
    one, same, other = (
        signal(7, noise_std_m_s2=0.5),
        signal(7, noise_std_m_s2=0.5),
        signal(8, noise_std_m_s2=0.5),
    )
    noise = np.array([one.sample(0.0) for _ in range(20000)])
    assert np.array_equal(noise, [same.sample(0.0) for _ in range(20000)])
    assert not np.array_equal(noise[:100], [other.sample(0.0) for _ in range(100)])
    assert np.std(noise) == pytest.approx(0.5, rel=0.03)
    assert abs(np.mean(noise)) < 0.02
    assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 0.03


@given(
    st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=30),
    st.floats(0.0, 0.01),
    st.floats(-10.0, 10.0),
    st.floats(0.1, 100.0),
)
def test_never_beyond_its_range(values: list[float], delay_s: float, bias: float, limit: float) -> None:
    sensor = signal(delay_s=delay_s, bias_m_s2=bias, range_m_s2=limit, noise_std_m_s2=0.5)
    assert all(abs(sensor.sample(value)) <= limit for value in values)
