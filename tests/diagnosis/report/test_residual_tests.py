"""The tests on residuals alarm as often as they say, whatever the colour, and see what they are for."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from stillarm.diagnosis.report.dependence import dependences_of
from stillarm.diagnosis.report.residual_tests import autocorrelation, crosscorrelation, square_correlation
from stillarm.diagnosis.report.residuals import noise_floor, spectrum_of

Array = NDArray[np.float64]
LAGS = np.arange(40)
TRIALS = 150


def coloured(random: np.random.Generator, n: int, stay: float) -> Array:
    """A first-order wander."""
    found: Array = lfilter([1.0], [1.0, -stay], random.standard_normal(n + 500))[500:]
    return found


@pytest.mark.slow
@pytest.mark.parametrize(("residual", "driver"), [(0.0, 0.0), (0.9, 0.0), (0.9, 0.95), (0.98, 0.9)])
def test_independent_series_rarely_alarm(residual: float, driver: float) -> None:
    random = np.random.default_rng(5)
    alarms = 0
    for _ in range(TRIALS):
        e, u = coloured(random, 2000, residual), coloured(random, 2000, driver)
        alarms += crosscorrelation(e, u, LAGS).significant
        alarms += square_correlation(e, u, LAGS).significant
    # one in a hundred is meant; strongly coloured series have few independent samples
    assert alarms <= 0.03 * 2 * TRIALS


def test_white_noise_is_white_and_a_wander_is_not() -> None:
    random = np.random.default_rng(6)
    lags = np.arange(1, 25)
    alarms = sum(autocorrelation(random.standard_normal(1500), lags).significant for _ in range(TRIALS))
    assert alarms <= 0.04 * TRIALS
    assert all(autocorrelation(coloured(random, 1500, 0.3), lags).significant for _ in range(20))


def test_a_residual_that_holds_the_input_is_seen_at_its_lag() -> None:
    random = np.random.default_rng(7)
    u = coloured(random, 3000, 0.8)
    e = coloured(random, 3000, 0.5) + 0.3 * np.roll(u, 7)
    found = crosscorrelation(e, u, LAGS)
    assert found.significant
    assert abs(found.lags[found.strongest] - 7) <= 2


def test_an_even_term_is_seen_by_the_squares_alone() -> None:
    random = np.random.default_rng(8)
    u = random.standard_normal(4000)
    e = random.standard_normal(4000) * (1.0 + 0.5 * u**2)
    assert not crosscorrelation(e, u, LAGS).significant
    assert square_correlation(e, u, LAGS).significant


def test_missing_samples_do_not_count() -> None:
    random = np.random.default_rng(9)
    u = random.standard_normal(4000)
    e = 0.3 * u + random.standard_normal(4000)
    e[1000:3000] = np.nan
    whole = autocorrelation(e, np.arange(1, 5))
    assert whole.band[0] == pytest.approx(3.02 / np.sqrt(2000), rel=0.01)
    assert crosscorrelation(e, u, LAGS).significant


def test_a_residual_follows_what_it_was_made_from_and_nothing_else() -> None:
    random = np.random.default_rng(10)
    time: Array = np.arange(8000, dtype=np.float64) * 0.001
    variables = {name: (coloured(random, 8000, 0.98), "m") for name in ("a", "b", "c", "d")}
    noise = coloured(random, 8000, 0.5)
    alarms = 0
    for _ in range(20):
        noise = coloured(random, 8000, 0.5)
        alarms += any(one.significant for one in dependences_of(noise, variables, time))
    assert alarms <= 2
    found = dependences_of(noise + 0.05 * variables["b"][0] ** 2, variables, time)
    assert [one.variable for one in found if one.significant] == ["b"]
    assert found[0].means[0] > 0.0 > found[0].means[len(found[0].means) // 2]


def test_the_floor_and_the_spectrum_of_white_noise_agree() -> None:
    values = 0.4 * np.random.default_rng(11).standard_normal(20000)
    values[3000:3100] = np.nan
    assert noise_floor(values) == pytest.approx(0.4, rel=0.05)
    spectrum = spectrum_of(values, 0.001)
    assert np.median(spectrum.density) == pytest.approx(spectrum.floor, rel=0.15)
    slow = values + np.cumsum(np.full(20000, 1e-4))
    assert noise_floor(slow) == pytest.approx(0.4, rel=0.05)
