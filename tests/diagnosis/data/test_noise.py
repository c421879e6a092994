"""A slow wander is known for what it is, although a drift is taken off it."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from stillarm.diagnosis.data.noise import (
    Colour,
    likeliest_level,
    log_likelihood,
    wander_colour,
    wander_colours,
)

Array = NDArray[np.float64]

FRAMES, RATE_HZ, TIME_S, SIZE = 1300, 65.0, 10.0, 0.006


def wander(seed: int) -> Array:
    """A delay that wanders with a correlation time of half the recording, and scatters."""
    random = np.random.default_rng(seed)
    kept = np.exp(-1.0 / (RATE_HZ * TIME_S))
    values = np.empty(FRAMES)
    now = random.standard_normal()
    for k in range(FRAMES):
        values[k] = now
        now = kept * now + np.sqrt(1.0 - kept * kept) * random.standard_normal()
    late: Array = SIZE * (np.sqrt(0.9) * values + np.sqrt(0.1) * random.standard_normal(FRAMES))
    return late


def slope_deviation(colour: Colour, late: Array) -> tuple[float, float]:
    """Slope of a drift, s/s, by generalised least squares under the colour, and what it says of its deviation."""
    x = np.arange(FRAMES) / RATE_HZ
    columns = np.stack([colour.whiten(one) for one in (np.ones(FRAMES), x, late)])[:, 1:]
    design, values = columns[:2].T, columns[2]
    solved, left, *_ = np.linalg.lstsq(design, values, rcond=None)
    covariance = np.linalg.inv(design.T @ design) * float(left[0]) / (len(values) - 2)
    return float(solved[1]), float(np.sqrt(covariance[1, 1]))


@pytest.mark.slow
def test_a_drift_is_about_as_sure_as_the_wander_lets_it_be() -> None:
    """The colour is learnt from two correlation times, so that its deviations stay too small by a half and more; with
    the trend merely taken off they would be too small three times."""
    off = []
    for seed in range(60):
        late = wander(seed)
        slope, deviation = slope_deviation(wander_colour(late, 15.0 * RATE_HZ), late)
        off.append(slope / deviation)
    assert 0.7 < float(np.sqrt(np.mean(np.square(off)))) < 2.0


@pytest.mark.parametrize("share", [0.0, 0.002, 0.01])
def test_the_likeliest_level_is_where_the_likelihood_is_largest(share: float) -> None:
    random = np.random.default_rng(7)
    values = random.normal(size=20000)
    values[random.random(len(values)) < share] *= 60.0
    found = likeliest_level(values, 1.0, 1e-3)
    around = found * np.array([0.95, 1.0, 1.05])
    nats = [float(log_likelihood(values / std, std).sum()) for std in around]
    assert np.argmax(nats) == 1
    assert likeliest_level(values, 1.0, 100.0) == 100.0


@pytest.mark.slow
def test_white_values_have_no_colour() -> None:
    seen = [wander_colour(np.random.default_rng(seed).standard_normal(900), 900.0) for seed in range(40)]
    assert sum(one.stay > 0.0 for one in seen) <= 1


def test_a_wander_strays_no_further_than_it_may() -> None:
    """What does is a drift, or another effect: taken for the usual wander it would hide one of ten deviations."""
    late = wander(3) + 0.002 * np.arange(FRAMES) / RATE_HZ
    bounded = wander_colour(late, 15.0 * RATE_HZ, most=0.5 * SIZE)
    innovations = float(
        np.std(bounded.whiten(late - np.polyval(np.polyfit(np.arange(FRAMES), late, 1), range(FRAMES))))
    )
    assert innovations * bounded.strayed < 0.55 * SIZE
    slope, deviation = slope_deviation(bounded, late)
    assert abs(slope) > 3.0 * deviation
    assert deviation < slope_deviation(wander_colour(late, 15.0 * RATE_HZ), late)[1]


def test_how_far_a_colour_strays_is_what_it_makes_of_white_values() -> None:
    one = Colour(stay=0.98, moving=0.8)
    made = lfilter([1.0, -one.moving], [1.0, -one.stay], np.random.default_rng(2).standard_normal(200_000))
    assert one.strayed == pytest.approx(float(np.std(made)), rel=0.05)


def test_how_far_a_colour_wanders_leaves_out_the_white_noise() -> None:
    """A wander of a given share of the variance, in white noise."""
    for time in (50.0, 2000.0):
        for colour, share in zip(wander_colours(time)[-11:], (0.02, 0.05, 0.1, 0.2, 0.35, 0.5), strict=False):
            assert (colour.wandered / colour.strayed) ** 2 == pytest.approx(share, rel=1e-6)
    assert Colour().wandered == 0.0
