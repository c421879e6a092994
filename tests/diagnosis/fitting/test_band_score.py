"""The likeliest level and shape of each band, held against a search by scipy."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from stillarm.diagnosis.fitting.band_score import SHAPES, Spectra, level_and_shape, log_density

BLOCKS, BANDS = 20, 12


def strayed(spread: float, least: float = 1e-12) -> Spectra:
    """Bands whose level strays from block to block by e^spread, in steps of a hundredfold from band to band."""
    rng = np.random.default_rng(3)
    count = np.round(np.geomspace(1.0, 200.0, BANDS)) * np.ones((BLOCKS, 1))
    level = 10.0 ** rng.uniform(-2.0, 2.0, BANDS) * np.exp(rng.normal(0.0, spread, (BLOCKS, BANDS)))
    return Spectra(count, level * rng.gamma(count), least)


@pytest.mark.parametrize("spread", [0.0, 0.1, 0.5, 1.0, 2.0, 4.0])
def test_no_level_and_shape_is_likelier(spread: float) -> None:
    """Also where blocks differ by factors of a thousand, and the mean says little."""
    by_bands = strayed(spread)
    level, shape = level_and_shape(by_bands, np.ones(BLOCKS, bool))
    density = log_density(by_bands.count, by_bands.power, level, shape).sum(axis=0)
    for band in range(BANDS):
        count, power = by_bands.count[:, band], by_bands.power[:, band]
        bounds = np.log(power.min()) - 12.0, np.log(power.max()) + 3.0

        def cost(log_level: float, a: float, count=count, power=power) -> float:  # type: ignore[no-untyped-def]
            return -float(log_density(count, power, np.exp(log_level), a).sum())

        best = min(
            minimize_scalar(cost, bounds=bounds, args=(a,), method="bounded", options={"xatol": 1e-9}).fun
            for a in SHAPES
        )
        assert density[band] == pytest.approx(-best, abs=1e-5)


def test_no_level_is_below_the_least_one() -> None:
    """Bands without power, and without samples, included."""
    by_bands = strayed(1.0, least=0.5)
    by_bands.power[:, 0] = 0.0
    by_bands.count[:, 1], by_bands.power[:, 1] = 0.0, 0.0
    level, _ = level_and_shape(by_bands, np.ones(BLOCKS, bool))
    assert level.min() == 0.5
    assert level[:2].tolist() == [0.5, 0.5]


def test_what_is_left_out_of_the_learning_has_no_say() -> None:
    by_bands, learnt_on = strayed(0.5), np.arange(BLOCKS) % 3 != 1
    level, shape = level_and_shape(by_bands, learnt_on)
    by_bands.power[~learnt_on] *= 1e6
    again, shape_again = level_and_shape(by_bands, learnt_on)
    assert np.array_equal(level, again) and np.array_equal(shape, shape_again)
