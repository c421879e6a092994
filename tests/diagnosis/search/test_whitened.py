"""Inner products by parts of the time say what the vectors themselves say."""

import numpy as np
import pytest
from numpy.typing import NDArray

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.fitting.fitted import least_level, make_data
from stillarm.diagnosis.search.begun import ground_of
from stillarm.diagnosis.search.whitened import Whitened, best_amounts
from tests.fixtures.synthetic import fitted, measured

Array = NDArray[np.float64]
SPLIT = interleaved(6.0)
ONSETS_S = (2.7, 0.9, 4.1, 4.1)


@pytest.fixture(scope="module")
def white() -> Whitened:
    last = fitted(measured(6.0, 3, {"arm.cubic_per_m2": 40.0}), split=SPLIT)
    return Whitened(make_data(last.world, SPLIT), last, ground_of(last, SPLIT).slopes)


def by_least_squares(white: Whitened, d: Array) -> tuple[Array, float]:
    """Amounts of directions and what they gain, from the vectors themselves."""
    left = d - white.basis @ np.linalg.lstsq(white.basis, d, rcond=None)[0]
    amounts: Array = np.linalg.lstsq(left, white.residual, rcond=None)[0]
    gain = 0.0
    for name, span in white.spans.items():
        before = white.residual[span]
        after = before - (left @ amounts)[span]
        least = (least_level(white.last.world, name) / white.last.sigma[name]) ** 2
        for sign, rest in ((1.0, after), (-1.0, before)):
            variance = max(np.mean(rest**2), least)
            gain += sign * -0.5 * (len(rest) * np.log(variance) + np.sum(rest**2) / variance)
    return amounts, gain


def directions(white: Whitened, k: int) -> Array:
    """Directions of which each is in a part of the channels, and of a size of its own."""
    rng = np.random.default_rng(5)
    d = rng.normal(size=(len(white.residual), k)) * 10.0 ** rng.uniform(-2, 2, k)
    for j in range(k):
        d[list(white.spans.values())[j % len(white.spans)], j] = 0.0
    return np.asfortranarray(d + 0.3 * white.residual[:, None])


@pytest.mark.parametrize("k", [1, 4])
def test_throughout_and_from_instants_on(white: Whitened, k: int) -> None:
    """The instants in any order, and one of them twice."""
    d = directions(white, k)
    whole, *later = white.products(d, ONSETS_S)
    time_s = np.concatenate(list(white.times_s.values()))
    for products, begins_s in zip([whole, *later], [-1.0, *ONSETS_S], strict=True):
        amounts = best_amounts(products)
        expected, gain = by_least_squares(white, d * (time_s >= begins_s)[:, None])
        assert amounts is not None
        np.testing.assert_allclose(amounts, expected, rtol=1e-8, atol=1e-10 * np.max(np.abs(expected)))
        assert white.gain(products, amounts) == pytest.approx(gain, rel=1e-8)


@pytest.mark.parametrize("share", [1e-3, 1e-5, 1e-7])
def test_a_direction_of_which_the_baseline_leaves_next_to_nothing(white: Whitened, share: float) -> None:
    """Sums of squares alone would hold rounding."""
    d = np.asfortranarray(white.basis[:, :1] * 100.0 + share * white.residual[:, None])
    (products,) = white.products(d)
    amounts = best_amounts(products)
    expected, gain = by_least_squares(white, d)
    assert amounts == pytest.approx(expected, rel=1e-3)
    assert amounts is not None and white.gain(products, amounts) == pytest.approx(gain, rel=1e-3)


def test_what_the_baseline_can_do_itself_shows_nothing(white: Whitened) -> None:
    (products,) = white.products(np.asfortranarray(white.basis[:, :1] * 100.0))
    assert best_amounts(products) is None
