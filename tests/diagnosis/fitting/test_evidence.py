"""The log score: the Gaussian density's of white noise, and what a rest in one band costs, by closed forms."""

from dataclasses import replace
from math import log

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import norm

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.fitting.band_score import SHAPES
from stillarm.diagnosis.fitting.evidence import foretold, noise_spectrum, score, score_of_noise
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.physics.space import Added
from tests.fixtures.synthetic import fitted, measured

Array = NDArray[np.float64]
BLOCKS, SAMPLES = 12, 499  # odd: each periodogram then holds whole pairs
STEP_S = 0.001
CYCLES = 6000
INSIDE = BLOCKS * SAMPLES
SPLIT = Split(  # and one last block, of which nothing is measured
    np.append(np.arange(BLOCKS + 1) * SAMPLES * STEP_S - 1e-6, 6.0),
    np.append(np.arange(BLOCKS) % 3 == 1, False),
)
BANDS = 33  # at most, from 0.3 to 500 Hz


@pytest.fixture(scope="module")
def plain() -> Fit:
    """A fit whose residuals are then put in its place."""
    return fitted(measured(6.0, 1))


def left(plain: Fit, residual: Array) -> Fit:
    """A fit that leaves that much in the accelerometer, and nothing is measured beside it."""
    whole = np.full(CYCLES, np.nan)
    whole[: len(residual)] = residual
    return replace(plain, residuals={"acceleration": whole})


def noise(seed: int, deviation: float = 1.0) -> Array:
    return np.random.default_rng(seed).normal(0.0, deviation, INSIDE)


def whole(plain: Fit, residual: Array) -> float:
    return float(score(left(plain, residual), SPLIT).whole["acceleration"].sum())


@pytest.mark.parametrize("deviation", [0.1, 1.0, 7.0])
def test_white_noise_has_the_gaussian_log_density(plain: Fit, deviation: float) -> None:
    """But for its constant, and for what levels learnt by bands gain on the true one: half a nat each on average."""
    data = noise(3, deviation)
    density = float(norm.logpdf(data, 0.0, deviation).sum()) + 0.5 * INSIDE * log(2.0 * np.pi)
    assert 0.0 < whole(plain, data) - density < BANDS


@pytest.mark.parametrize("ratio", [0.5, 2.0, 30.0])
def test_a_level_of_noise_costs_its_logarithm_for_each_sample(plain: Fit, ratio: float) -> None:
    """All learnt: the scale of a whole residual is worth N log(ratio)."""
    lost = whole(plain, noise(4)) - whole(plain, ratio * noise(4))
    assert lost == pytest.approx(INSIDE * log(ratio), rel=1e-6)


def test_noise_alone_would_score_as_its_own_density_does_on_average(plain: Fit) -> None:
    """White noise has no colour: its level is learnt from `white` up, and the score is E log N without its constant."""
    for deviation in (0.3, 2.0):
        one = left(plain, noise(5, deviation))
        ideal = score_of_noise(one, "acceleration", SPLIT, deviation, 0.0)
        assert ideal == pytest.approx(INSIDE * (-log(deviation) - 0.5), abs=0.02 * INSIDE)
        assert (
            abs(whole(plain, noise(5, deviation)) - ideal)
            < 4.0 * (0.5 * INSIDE) ** 0.5 + BANDS + 0.02 * INSIDE
        )


def test_what_is_finer_than_matters_makes_up_for_no_departure(plain: Fit) -> None:
    """A sensor of a twentieth of what matters: its own noise is nothing to be explained, and a slow departure of many
    times what matters is, however well all other bands are foretold."""
    fine, matters = 0.05 * noise(7), 1.0
    of_noise = score_of_noise(left(plain, fine), "acceleration", SPLIT, 0.05, matters)
    assert of_noise == pytest.approx(whole(plain, fine), abs=1e-6 * INSIDE)
    slow = fine + 30.0 * sinusoid(1)
    gained = score_of_noise(left(plain, slow), "acceleration", SPLIT, 0.05, matters) - whole(plain, slow)
    # one value of each block's periodogram, whose level falls to that of what matters
    assert gained == pytest.approx(BLOCKS * log(30.0**2 * SAMPLES / 2.0), rel=0.05)


def test_a_departure_in_some_blocks_is_no_noise(plain: Fit) -> None:
    """What rings in a third of the blocks alone does not raise the level that noise is taken to have."""
    count, quiet = noise_spectrum(left(plain, noise(6)), "acceleration", SPLIT, 1.0)
    ringing = sinusoid(20) * (np.arange(INSIDE) // SAMPLES % 3 == 0)
    _, loud = noise_spectrum(left(plain, noise(6) + 5.0 * ringing), "acceleration", SPLIT, 1.0)
    assert float(count @ loud) == pytest.approx(float(count @ quiet), rel=0.02)


def sinusoid(bin_of_block: int) -> Array:
    """Of whole periods in each block, so that it lies in one band."""
    return np.sqrt(2.0) * np.cos(2.0 * np.pi * bin_of_block * np.arange(INSIDE) / SAMPLES)


def bins_beside(bin_of_block: int) -> int:
    """How many frequencies of a block's periodogram its band holds: bands a quarter wide from 0.3 Hz to 500 Hz."""
    count = int(np.log(500.0 / 0.3) / np.log(1.25))
    edges = np.geomspace(0.3, 500.5, count + 1)
    hz = np.arange(1, SAMPLES // 2 + 1) / (SAMPLES * STEP_S)
    own = bin_of_block / (SAMPLES * STEP_S)
    low = edges[edges <= own].max()
    high = edges[edges > own].min()
    return int(np.sum((hz >= low) & (hz < high)))


@pytest.mark.parametrize("bin_of_block", [3, 20, 100])
def test_a_sinusoid_costs_what_its_band_holds_and_no_more(plain: Fit, bin_of_block: int) -> None:
    """A power P of it in n bins raises their level from 1 to 1 + P / n, which costs n log(1 + P / n) a block."""
    many, size = bins_beside(bin_of_block), 2.0
    power = size**2 * SAMPLES / 2.0  # |X|^2 / N of sqrt(2) A cos
    lost = whole(plain, noise(6)) - whole(plain, noise(6) + size * sinusoid(bin_of_block))
    assert lost == pytest.approx(BLOCKS * many * log(1.0 + power / many), rel=0.1, abs=3.0 * BLOCKS**0.5)


def test_a_louder_sinusoid_costs_its_band_alone_however_many_samples_show_it(plain: Fit) -> None:
    """Ten times the size: n log 100 for each block, where white noise would cost N log 10."""
    many = bins_beside(20)
    quiet, loud = noise(7) + 100.0 * sinusoid(20), noise(7) + 1000.0 * sinusoid(20)
    lost = whole(plain, quiet) - whole(plain, loud)
    assert lost == pytest.approx(BLOCKS * many * log(100.0), rel=0.02)
    assert lost < 0.1 * INSIDE * log(10.0)


def test_a_constant_costs_half_a_band_of_one(plain: Fit) -> None:
    """One number for each block, with half the weight of a pair: its mean."""
    lost = whole(plain, noise(8)) - whole(plain, noise(8) + 2.0)
    mean_power = 4.0 * SAMPLES
    assert lost == pytest.approx(BLOCKS * 0.5 * log(1.0 + mean_power), rel=0.15)


def test_one_loud_block_costs_the_others_little(plain: Fit) -> None:
    """A block's level may lie off the channel's: a Gaussian would make the other eleven pay."""
    data = noise(9)
    before = score(left(plain, data), SPLIT).whole["acceleration"]
    data[5 * SAMPLES : 6 * SAMPLES] *= 10.0
    after = score(left(plain, data), SPLIT).whole["acceleration"]
    others = np.arange(BLOCKS + 1) != 5
    assert before[5] - after[5] > 0.8 * SAMPLES * log(10.0)
    gaussian = 0.5 * 11 * SAMPLES * log(1.0 + 99.0 / BLOCKS)
    assert float((before - after)[others].sum()) < 0.25 * gaussian


def test_what_is_held_out_teaches_nothing(plain: Fit) -> None:
    data = noise(10)
    first = score(left(plain, data), SPLIT)
    data[SAMPLES : 2 * SAMPLES] *= 3.0  # of the second block, held out
    other = score(left(plain, data), SPLIT)
    rest = np.arange(BLOCKS + 1) != 1
    assert other.held_out["acceleration"][rest] == pytest.approx(first.held_out["acceleration"][rest])
    assert other.held_out["acceleration"][1] < first.held_out["acceleration"][1] - 0.5 * SAMPLES
    assert np.any(other.whole["acceleration"][rest] != first.whole["acceleration"][rest])


def test_blocks_with_next_to_no_samples_count_for_nothing(plain: Fit) -> None:
    data = noise(11)
    data[2 * SAMPLES + 11 : 3 * SAMPLES] = np.nan
    found = score(left(plain, data), SPLIT)
    assert found.whole["acceleration"][2] == 0.0 and found.held_out["acceleration"][2] == 0.0


@pytest.mark.parametrize("missing", [20, 60, 90])
def test_a_block_tells_no_more_than_it_has_samples(plain: Fit, missing: int) -> None:
    """Of a scale: N log(ratio), N being what was measured, wherever the holes lie."""
    holes = np.where(np.arange(INSIDE) % 100 < missing, np.nan, noise(12))
    lost = whole(plain, holes) - whole(plain, 5.0 * holes)
    assert lost == pytest.approx(int(np.isfinite(holes).sum()) * log(5.0), rel=0.02)


def test_a_residual_of_nothing_is_as_good_as_a_simulation_can_be(plain: Fit) -> None:
    found = score(left(plain, np.zeros(INSIDE)), SPLIT)
    assert (
        np.isfinite(found.whole["acceleration"]).all() and np.isfinite(found.held_out["acceleration"]).all()
    )


def test_a_gain_is_the_sum_of_all_channels(plain: Fit) -> None:
    split = Split(np.arange(7) * 1.0, np.arange(6) % 3 == 1)
    before = score(plain, split)
    louder = {**plain.residuals, "acceleration": 2.0 * plain.residuals["acceleration"]}
    after = score(replace(plain, residuals=louder), split)
    assert after.gains(before)["joint_position"] == 0.0
    assert after.gains(before)["acceleration"] == pytest.approx(-6000 * log(2.0), rel=2e-3)
    assert float(after.gain(before).sum()) == pytest.approx(after.gains(before)["acceleration"])
    assert after.gain(before).shape == after.gain(before, whole=False).shape == (6,)
    assert max(SHAPES) == SHAPES[-1]  # the shape that stands for no spread between blocks


@pytest.mark.parametrize("over_time", [False, True])
def test_a_course_is_not_judged_where_it_was_not_fitted_to(plain: Fit, over_time: bool) -> None:
    """Nothing is measured in the first block, and the second is held out: what a course is there, nobody knows."""
    data = noise(5)
    data[:SAMPLES] = np.nan
    better = 0.5 * data
    better[SAMPLES : 2 * SAMPLES] += 30.0
    course = Added("course", {"acceleration": np.zeros((CYCLES, 2))}, 1.0, over_time)
    world = plain.world.changed(added=(course,))
    before, after = left(plain, data), replace(left(plain, better), world=world)
    found = foretold(after, score(before, SPLIT), SPLIT, score(after, SPLIT))
    assert len(found) == int(SPLIT.held.sum())
    if over_time:
        assert found.min() > 0.0
        assert found[0] == pytest.approx(found[1:].mean())
    else:
        assert found[0] < -SAMPLES
