"""Power that stays where it is in the spectrum, told from white noise."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from stillarm.diagnosis.steady_spectrum import steady_spectrum

Array = NDArray[np.float64]

SAMPLES, BLOCKS = 30000, 20
TIME = np.arange(SAMPLES) * 0.001
BLOCK = np.arange(SAMPLES) * BLOCKS // SAMPLES
SURE_NATS = 12.0  # what a verdict asks


def noise(seed: int) -> Array:
    return np.random.default_rng(seed).normal(size=SAMPLES)


def gained(values: Array, known: NDArray[np.bool_] | None = None) -> Array:
    return steady_spectrum(values, np.ones(SAMPLES, bool) if known is None else known, BLOCK, BLOCKS)


def howls(seed: int) -> Array:
    """A resonance of 35 Hz that is heard for half a second, five times in half a minute."""
    ringing = lfilter([1.0], [1.0, -2.0 * 0.98 * np.cos(2 * np.pi * 0.035), 0.98**2], noise(seed + 100))
    heard = np.mod(TIME, 6.0) < 0.5
    return np.asarray(0.7 * ringing / np.std(ringing) * heard)


def sweeps(seed: int) -> Array:
    """A tone that is folded down, and moves about as a gear's speed does, while the gear turns."""
    speed = np.sin(2 * np.pi * 0.11 * TIME + seed)
    return np.asarray(0.5 * (np.abs(speed) > 0.8) * np.sin(3e3 * np.cumsum(speed) * 0.001))


@pytest.mark.parametrize("seed", range(12))
def test_white_noise_is_white(seed: int) -> None:
    assert gained(noise(seed)).sum() < 0.5 * SURE_NATS


@pytest.mark.parametrize("added", [howls, sweeps])
@pytest.mark.parametrize("seed", range(3))
def test_what_sounds_in_a_band_for_a_while_is_heard(added: Callable[[int], Array], seed: int) -> None:
    assert gained(noise(seed) + added(seed)).sum() > SURE_NATS


def test_louder_white_noise_for_a_single_window_is_no_discovery() -> None:
    values = noise(1)
    values[7040:7072] *= 3.0
    assert gained(values).sum() < SURE_NATS


def test_what_is_not_known_says_nothing() -> None:
    values = noise(2) + howls(2)
    known = np.mod(TIME, 6.0) >= 0.55
    assert gained(values, known).sum() < 0.5 * SURE_NATS


def test_too_little_says_nothing() -> None:
    few = np.zeros(1000, np.int64)
    assert not steady_spectrum(noise(1)[:1000], np.ones(1000, bool), few, 1).any()
