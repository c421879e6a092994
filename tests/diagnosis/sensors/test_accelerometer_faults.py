"""Single samples that are far off, told from the tops of pulses."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.fitting.fitted import make_data
from stillarm.diagnosis.sensors.accelerometer_faults import SURE_NATS, outliers, pulse_gains, strikes
from tests.fixtures.synthetic import fitted, measured

Array = NDArray[np.float64]

TOPS = np.arange(500, 10000, 1000)


def with_peaks(seed: int, shape: tuple[float, ...]) -> Array:
    """White noise of level one, and ten peaks of that shape whose third value is the top."""
    values = np.random.default_rng(seed).normal(size=11000)
    for i, part in enumerate(shape):
        values[TOPS + i - 2] += part
    return values


def tops_of(values: Array) -> NDArray[np.int64]:
    """The largest sample of each peak."""
    return np.asarray(TOPS + (values[TOPS + 1] > values[TOPS]), dtype=np.int64)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("shape", [(0.0, 0.0, 9.0, 0.0, 0.0), (0.0, 0.0, 9.0, 8.0, 0.0)])
def test_spikes_of_a_sample_or_two_are_spikes(seed: int, shape: tuple[float, ...]) -> None:
    values = with_peaks(seed, shape)
    assert pulse_gains(values, tops_of(values)).sum() < 0.0


@pytest.mark.parametrize("seed", range(5))
def test_what_rises_and_falls_is_a_pulse(seed: int) -> None:
    assert pulse_gains(with_peaks(seed, (1.0, 4.0, 9.0, 4.0, 1.0)), TOPS).sum() > SURE_NATS


def test_an_unknown_neighbour_says_nothing() -> None:
    values = with_peaks(1, (1.0, 4.0, 9.0, 4.0, 1.0))
    values[TOPS + 1] = np.nan
    assert not pulse_gains(values, TOPS).any()


TIME = np.arange(20000) * 0.001
SPEED = np.where(TIME % 2.0 < 1.0, np.sin(2.0 * np.pi * 2.0 * TIME), 0.0)  # a second's moves, a second's rest
REVERSALS = np.flatnonzero((np.abs(TIME % 0.25) < 1e-9) & (TIME % 2.0 < 1.0))


def flags_at(places: NDArray[np.int64]) -> NDArray[np.bool_]:
    """What stands out, by its samples."""
    found = np.zeros(len(TIME), bool)
    found[np.clip(places, 0, len(TIME) - 1)] = True
    return found


@pytest.mark.parametrize("seed", range(10))
def test_what_stands_out_where_the_joint_turns_is_a_gears(seed: int) -> None:
    random = np.random.default_rng(seed)
    assert strikes(flags_at(REVERSALS + random.integers(5, 40, len(REVERSALS))), SPEED, 0.001)


@pytest.mark.parametrize("seed", range(10))
def test_what_stands_out_at_any_time_is_a_sensors(seed: int) -> None:
    random = np.random.default_rng(seed)
    assert not strikes(flags_at(random.integers(0, len(TIME), 60)), SPEED, 0.001)


def test_few_or_none_at_rest_or_without_a_motion_say_nothing() -> None:
    assert not strikes(flags_at(REVERSALS[:2] + 20), SPEED, 0.001)
    assert not strikes(flags_at(REVERSALS[:0]), SPEED, 0.001)
    assert not strikes(flags_at(REVERSALS), np.zeros(len(TIME)), 0.001)


def test_a_reading_at_the_limit_where_none_is_foretold_stands_out() -> None:
    data = measured(6.0, 1)
    at = np.arange(1000, 5500, 500)
    spiked = data.acceleration.copy()
    spiked[at] = 19.6  # the sensor's range
    last = fitted(replace(data, acceleration=spiked))
    found = outliers(make_data(last.world, interleaved(6.0)), last)
    assert found is not None
    flagged = set(np.flatnonzero(found.flags).tolist())
    assert flagged <= set(at.tolist())
    assert len(flagged) >= len(at) - 1  # one may lie where a jump of the command is not foretold
