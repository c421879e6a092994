"""A walk of an accelerometer's bias is told from its noise, from a slow line, and from what gravity explains."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision.explain import explain
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms import sensor_walk
from stillarm.diagnosis.forms.sensor_walk import BIAS
from stillarm.diagnosis.forms.sensor_walk import BIAS_WALK as FORM
from tests.fixtures.synthetic import NOISE, fitted, measured

Array = NDArray[np.float64]
SECONDS, CYCLES, STEP = 20.0, 20_000, 0.01
"""The walk's steps, m/s^2 from one millisecond to the next: 1.4 m/s^2 by the end, beside a noise of 0.3."""
bias_walk = partial(sensor_walk.walk_in, channel=BIAS)
is_foretold = partial(sensor_walk.is_foretold, channel=BIAS)


def with_reading_off(off_m_s2: Array) -> Fit:
    data = measured(SECONDS, 1)
    return fitted(replace(data, acceleration=data.acceleration + off_m_s2))


def strayed(step: float = STEP, seed: int = 5) -> Array:
    return np.cumsum(np.random.default_rng(seed).normal(0.0, step, CYCLES))


def test_a_walk_has_its_steps() -> None:
    walk = bias_walk(with_reading_off(strayed()))
    assert walk is not None and walk.nats > 50.0
    assert walk.step == pytest.approx(STEP * np.sqrt(400.0), rel=0.3)  # between knots, 0.4 s apart


TIME = np.arange(CYCLES) * 1e-3


@pytest.mark.parametrize(
    "off",
    [np.zeros(CYCLES), strayed(2e-5 * NOISE["acceleration"]), 1.2 * np.sin(2.0 * np.pi * 0.35 * TIME)],
    ids=["nothing", "next to nothing", "a slow swing"],
)
def test_what_is_no_walk_has_no_such_form(off: Array) -> None:
    assert FORM.added is not None
    assert FORM.added(with_reading_off(off)) == ()


def test_missing_samples_are_no_steps() -> None:
    gapped = strayed()
    gapped[5000:5300] = np.nan
    walk = bias_walk(with_reading_off(gapped))
    assert walk is not None
    assert walk.step == pytest.approx(STEP * np.sqrt(400.0), rel=0.3)


def test_a_walk_gives_way_to_what_foretells_it_and_to_nothing_that_leaves_it_there() -> None:
    strays, clean = with_reading_off(strayed()), with_reading_off(np.zeros(CYCLES))
    assert is_foretold(strays, clean)
    assert not is_foretold(strays, strays)


@pytest.mark.slow
def test_a_walk_is_the_biases_and_named() -> None:
    plain = with_reading_off(strayed())
    found = explain(plain, interleaved(SECONDS), only=["accelerometer_bias_drift", "second_bending_mode"])
    assert [one.cause for one in found.findings] == ["accelerometer_bias_drift"]
