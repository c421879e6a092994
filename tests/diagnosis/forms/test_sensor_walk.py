"""A walk of the images is told from white noise, from a rest that swings, and from next to nothing."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision.explain import explain
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms import sensor_walk
from stillarm.diagnosis.forms.sensor_walk import IMAGE_WALK as FORM
from stillarm.diagnosis.forms.sensor_walk import IMAGES
from stillarm.diagnosis.sensors.late_bursts import wander_of
from tests.fixtures.synthetic import NOISE, fitted, measured

SECONDS, STEP_PX = 20.0, 0.3
image_walk = partial(sensor_walk.walk_in, channel=IMAGES)
is_foretold = partial(sensor_walk.is_foretold, channel=IMAGES)
Array = NDArray[np.float64]


def with_images_off(off_px: Array, seconds: float = SECONDS) -> Fit:
    data = measured(seconds, 1)
    seen = data.frames.displacement_px
    return fitted(replace(data, frames=replace(data.frames, displacement_px=seen + off_px[: len(seen)])))


def strayed(step_px: float, seed: int = 3) -> Array:
    return np.cumsum(np.random.default_rng(seed).normal(0.0, step_px, 5000))


def test_a_walk_is_measured() -> None:
    noise = np.random.default_rng(4).normal(0.0, 0.5, 5000)
    found = wander_of(strayed(0.2) + noise)
    assert found is not None
    assert found.noise_std == pytest.approx(0.5, rel=0.05)
    assert found.std * np.sqrt(1.0 - found.stay**2) == pytest.approx(0.2, rel=0.15)
    assert float(np.nanstd(found.innovations)) == pytest.approx(1.0, rel=0.05)
    assert found.nats > found.white_nats + 1000.0


def test_a_few_images_tell_of_none() -> None:
    assert wander_of(np.zeros(5)) is None


@pytest.mark.slow
def test_a_walk_is_the_trackers_and_named() -> None:
    plain = with_images_off(strayed(STEP_PX))
    walk = image_walk(plain)
    assert walk is not None and walk.nats > 100.0
    found = explain(plain, interleaved(SECONDS), only=["tracking_drift", "second_bending_mode"])
    assert [one.cause for one in found.findings] == ["tracking_drift"]


@pytest.mark.slow
@pytest.mark.parametrize(
    "off",
    [
        np.zeros(5000),
        strayed(0.02 * NOISE["displacement"]),
        4.0 * NOISE["displacement"] * np.sin(2.0 * np.pi * 0.7 * np.arange(5000) / 65.0),
    ],
    ids=["nothing", "next to nothing", "a swing"],
)
def test_what_is_no_walk_has_no_such_form(off: Array) -> None:
    assert FORM.added is not None
    assert FORM.added(with_images_off(off)) == ()


@pytest.mark.slow
def test_what_comes_back_within_seconds_of_a_minute_is_no_trackers() -> None:
    """A tip in gusts strays by as much, for longer than it swings, and is held by the arm."""
    rng, stay = np.random.default_rng(8), np.exp(-1.0 / (65.0 * 2.0))
    gusts = np.zeros(5000)
    for k in range(1, len(gusts)):
        gusts[k] = stay * gusts[k - 1] + 4.0 * np.sqrt(1.0 - stay**2) * rng.normal()
    assert image_walk(with_images_off(gusts, 60.0)) is None
    assert image_walk(with_images_off(strayed(STEP_PX), 60.0)) is not None


def test_a_walk_gives_way_to_what_foretells_the_images_and_to_nothing_that_leaves_it_there() -> None:
    strays, clean = with_images_off(strayed(STEP_PX)), with_images_off(np.zeros(5000))
    assert is_foretold(strays, clean)
    assert not is_foretold(strays, strays)


@pytest.mark.slow
def test_a_walk_gives_way_to_what_foretells_most_of_where_it_went() -> None:
    """A pull is left, say, that nobody has found."""
    rng = np.random.default_rng(6)
    way, rest = strayed(STEP_PX), np.cumsum(rng.normal(0.0, 0.2 * STEP_PX, 5000))
    assert is_foretold(with_images_off(way + rest), with_images_off(rest))
    assert not is_foretold(with_images_off(way + rest), with_images_off(0.8 * way + rest))
