"""A channel's noise, whatever the model leaves beside it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from stillarm.diagnosis.data.noise import MATTERS_OF_MOTION
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.fitting.channel_noise import least_that_matters, noise_of, white_noise
from stillarm.diagnosis.fitting.fitted import Fit
from tests.fixtures.synthetic import NOISE, fitted, measured, with_rest

SPLIT = interleaved(6.0)


@pytest.fixture(scope="module")
def plain() -> Fit:
    return fitted(measured(6.0, 1))


def test_a_channels_noise_is_its_white_noise(plain: Fit) -> None:
    loud = with_rest(plain, "acceleration", 10.0 * NOISE["acceleration"])
    for fit in (plain, loud):
        assert white_noise(fit, "acceleration") == pytest.approx(NOISE["acceleration"], rel=0.1)


def test_noise_with_a_colour_is_no_less_for_it(plain: Fit) -> None:
    """A sensor's filter takes the fastest of its noise: what changes from sample to sample tells too little of it."""
    name, colour = "acceleration", 0.3
    white = np.random.default_rng(5).normal(0.0, np.sqrt(1.0 - colour**2), len(plain.residuals[name]))
    coloured = replace(plain, residuals={**plain.residuals, name: lfilter([1.0], [1.0, -colour], white)})
    assert white_noise(coloured, name) < 0.85
    assert noise_of(coloured, name, SPLIT) == pytest.approx(1.0, rel=0.07)


def test_what_rings_nearly_as_fast_as_the_images_is_no_noise_of_theirs(plain: Fit) -> None:
    """It changes from image to image as much as noise does, at a few frequencies alone."""
    name, frames = "displacement", len(plain.residuals["displacement"])
    noise = np.random.default_rng(4).normal(0.0, NOISE[name], frames)
    rings = 10.0 * NOISE[name] * np.sin(2.0 * np.pi * 0.38 * np.arange(frames))
    ringing = replace(plain, residuals={**plain.residuals, name: noise + rings})
    assert white_noise(ringing, name) == pytest.approx(NOISE[name], rel=0.3)


@pytest.mark.parametrize("images", [12, 70])
def test_a_few_images_have_the_noise_that_changes_from_one_to_the_next(plain: Fit, images: int) -> None:
    few = {**plain.residuals, "displacement": plain.residuals["displacement"][:images]}
    noise = white_noise(replace(plain, residuals=few), "displacement")
    assert noise == pytest.approx(NOISE["displacement"], rel=0.6)


def test_what_matters_is_a_part_of_the_motion_however_little_the_noise(plain: Fit) -> None:
    """An encoder with next to no noise asks for no drive that is as good."""
    least = least_that_matters(plain, "joint_position")
    assert least == pytest.approx(MATTERS_OF_MOTION * plain.world.variation("joint_position"))
    assert least_that_matters(plain, "displacement") >= 0.02


def test_a_sensor_at_its_limit_has_the_noise_that_it_has_below_it() -> None:
    """Three samples of four are pinned, and left to nothing by a model with that limit."""
    data = measured(6.0, 1)
    limit = float(np.quantile(np.abs(data.acceleration), 0.25))
    clipped = replace(data, acceleration=np.clip(data.acceleration, -limit, limit))
    fit = fitted(clipped)
    pinned = np.abs(clipped.acceleration) >= limit
    noise = np.random.default_rng(2).normal(0.0, NOISE["acceleration"], data.cycles)
    left = replace(fit, residuals={**fit.residuals, "acceleration": np.where(pinned, 0.0, noise)})
    assert white_noise(left, "acceleration") == pytest.approx(NOISE["acceleration"], rel=0.15)
