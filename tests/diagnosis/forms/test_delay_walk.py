"""A delay that strays further than the model states is told from its usual wander, from a drift, from a step and from
bursts."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from stillarm.common.files.model import Model, Timing
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision.explain import explain
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.delay_walk import FORM, delay_walk, is_foretold
from stillarm.diagnosis.forms.sensor_walk import IMAGE_WALK
from tests.fixtures.synthetic import ARRIVAL_STD_S, MODEL, fitted, measured

SECONDS, RATE_HZ = 24.0, 65.0
STATED = Model(arm=MODEL.arm, camera=MODEL.camera, timing=Timing(capture_delay_std_s=ARRIVAL_STD_S))
Array = NDArray[np.float64]
TIME_S = np.arange(5000) / RATE_HZ


def with_arrivals_late(late_s: Array) -> Fit:
    data = measured(SECONDS, 1, model=STATED)
    received = data.frames.received_s
    frames = replace(data.frames, received_s=received + late_s[: len(received)])
    return fitted(replace(data, frames=frames), model=STATED)


def bent(size_s: float) -> Array:
    """To and back."""
    late: Array = size_s * np.sin(np.pi * TIME_S / SECONDS)
    return late


def usual_wander(seed: int) -> Array:
    """A third of the stated variance, for some 10 s."""
    random, kept = np.random.default_rng(seed), float(np.exp(-1.0 / (10.0 * RATE_HZ)))
    late, now = np.empty(5000), random.normal()
    for k in range(5000):
        late[k] = now
        now = kept * now + np.sqrt(1.0 - kept * kept) * random.normal()
    return np.asarray(ARRIVAL_STD_S / np.sqrt(3.0) * late)


@pytest.mark.slow
def test_a_delay_that_strays_is_named() -> None:
    strays = with_arrivals_late(bent(0.025))
    walk = delay_walk(strays)
    assert walk is not None and walk.nats > 20.0
    found = explain(strays, interleaved(SECONDS), only=["delay_drift", "clock_step"])
    assert [one.cause for one in found.findings] == ["delay_drift"]
    assert found.findings[0].form == FORM.name


def bursts() -> Array:
    late: Array = np.where((TIME_S % 2.0) < 0.08, 0.02, 0.0)
    return late


@pytest.mark.slow
@pytest.mark.parametrize(
    "late",
    [np.zeros(5000), usual_wander(1), usual_wander(2), 0.001 * TIME_S, bursts()],
    ids=["nothing", "usual", "usual again", "a straight drift", "bursts"],
)
def test_what_is_no_walk_has_no_such_form(late: Array) -> None:
    assert FORM.added is not None
    assert FORM.added(with_arrivals_late(late)) == ()


@pytest.mark.slow
def test_a_walk_gives_way_to_what_foretells_the_arrivals_and_to_nothing_that_leaves_it_there() -> None:
    strays, clean = with_arrivals_late(bent(0.025)), with_arrivals_late(np.zeros(5000))
    assert is_foretold(strays, clean)
    assert not is_foretold(strays, strays)


def test_where_no_scatter_is_stated_no_walk_is_beyond_it() -> None:
    data = measured(SECONDS, 1)
    silent = Model(arm=MODEL.arm, camera=MODEL.camera, timing=Timing(capture_delay_std_s=0.0))
    frames = replace(data.frames, received_s=data.frames.received_s + bent(0.025)[: len(data.frames)])
    assert delay_walk(fitted(replace(data, frames=frames), model=silent)) is None


def test_a_walk_of_the_delay_and_one_of_the_images_have_terms_of_their_own() -> None:
    """With terms of one name the amounts of the one were taken for the other's."""
    data = measured(SECONDS, 1, model=STATED)
    frames = data.frames
    count = len(frames)
    strayed_px = np.cumsum(np.random.default_rng(3).normal(0.0, 0.3, count))
    both = replace(
        frames,
        received_s=frames.received_s + bent(0.025)[:count],
        displacement_px=frames.displacement_px + strayed_px,
    )
    last = fitted(replace(data, frames=both), model=STATED)
    added = [form.added(last) for form in (FORM, IMAGE_WALK) if form.added is not None]
    names = [terms[0].name for terms in added if terms]
    assert len(set(names)) == len(names) == 2
