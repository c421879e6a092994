"""An accelerometer at its limit: where it stays at one size while the motion goes on."""

import numpy as np
import pytest
from numpy.typing import NDArray

from stillarm.diagnosis.sensors.accelerometer_faults import plateau_of

Array = NDArray[np.float64]
NOISE = 0.25
TIME = np.arange(6000) * 0.001


def ring(peak: float = 31.0) -> Array:
    """A ring-down after an impact at 2 s, in the middle of little motion."""
    after = np.maximum(TIME - 2.0, 0.0)
    return np.asarray(peak * np.exp(-0.3 * after) * np.sin(2.0 * np.pi * 4.0 * after))


def shown(motion: Array, seed: int = 1) -> Array:
    """With noise."""
    return motion + np.random.default_rng(seed).normal(0.0, NOISE, len(motion))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_level_that_cuts_a_few_peaks_is_found(seed: int) -> None:
    found = plateau_of(shown(np.clip(ring(), -26.5, 26.5), seed), ring(), NOISE)
    assert found is not None
    assert found == pytest.approx(26.5, abs=0.2)


def test_a_sensor_in_the_noise_of_its_peaks_has_none() -> None:
    for seed in range(20):
        assert plateau_of(shown(ring(), seed), ring(), NOISE) is None


@pytest.mark.parametrize("off", [0.9, 0.97])
def test_a_gain_that_is_off_is_no_level(off: float) -> None:
    """The simulation is larger at each peak, but the sensor follows it there."""
    assert plateau_of(shown(off * ring()), ring(), NOISE) is None


def test_a_vibration_that_is_softer_when_it_is_large_is_no_level() -> None:
    motion = ring()
    assert plateau_of(shown(motion - 1e-4 * motion**3), motion, NOISE) is None


ONE_PEAK = np.where(TIME < 2.1, ring(), 0.0)  # half a period


def test_one_peak_that_is_merely_lower_may_be_anything() -> None:
    lower = ONE_PEAK - np.where(ONE_PEAK > 26.0, 0.7 * (ONE_PEAK - 26.0), 0.0)
    for seed in range(20):
        assert plateau_of(shown(lower, seed), ONE_PEAK, NOISE) is None


def test_one_peak_that_is_flat_is_a_level() -> None:
    found = plateau_of(shown(np.clip(ONE_PEAK, -26.5, 26.5)), ONE_PEAK, NOISE)
    assert found is not None
    assert found == pytest.approx(26.5, abs=0.2)


def test_a_converters_last_value_that_comes_again_and_again_is_a_level() -> None:
    """The motion goes beyond it by little, and the noise is above it half of the time."""
    barely = ONE_PEAK * 28.0 / 31.0
    for seed in range(10):
        rounded = np.round(shown(barely, seed) / 0.01) * 0.01
        assert plateau_of(rounded, barely, NOISE) is None
        assert plateau_of(np.clip(rounded, -27.2, 27.2), barely, NOISE) == pytest.approx(27.2)


def test_a_coarse_converter_shows_its_values_again_and_again() -> None:
    coarse = np.round(shown(ONE_PEAK) / 2.0) * 2.0
    assert plateau_of(coarse, ONE_PEAK, NOISE) is None


def test_samples_that_are_missing_say_nothing() -> None:
    cut = shown(np.clip(ring(), -26.5, 26.5))
    cut[::7] = np.nan
    found = plateau_of(cut, ring(), NOISE)
    assert found is not None
    assert found == pytest.approx(26.5, abs=0.2)
