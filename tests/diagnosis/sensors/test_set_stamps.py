"""The clock of a triggered camera, by whose stamps its images are dated, that was set."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.data.frame_times import set_stamps
from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.events.impacts import fit_with_impacts
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.sensors.clocks import without_set_stamps
from tests.diagnosis.data.test_repeated_stamps import FIRST, SPLIT, TRIGGERED, stamped


def set_by(step_s: float, *, requested: bool = True) -> Measured:
    """Stamps that step by step_s at frame FIRST."""
    data = stamped(0)
    number = np.arange(len(data.frames.counter))
    stamps = data.frames.captured_s + np.where(number >= FIRST, step_s, 0.0)
    started = data.frames.started_s if requested else np.full(len(number), np.nan)
    return replace(data, frames=replace(data.frames, captured_s=stamps, started_s=started))


@pytest.mark.slow
@pytest.mark.parametrize(("step_s", "requested"), [(0.01, True), (-0.004, True), (0.01, False)])
def test_stamps_that_step_against_requests_and_images_are_of_a_clock_that_was_set(
    step_s: float, requested: bool
) -> None:
    data = set_by(step_s, requested=requested)
    before = fit_with_impacts(World(data, TRIGGERED), SPLIT)
    after, laws = without_set_stamps(before, SPLIT)
    assert [one.cause for one in laws] == ["clock_step"]
    assert laws[0].values["onset_s"][0] == pytest.approx(float(data.frames.received_s[FIRST]), abs=0.05)
    assert laws[0].values["step_s"][0] == pytest.approx(step_s, abs=0.001)
    assert laws[0].note.startswith("captured_s")
    assert after.train_log_likelihood > before.train_log_likelihood


@pytest.mark.slow
@pytest.mark.parametrize(
    "data",
    [
        pytest.param(stamped(0), id="nothing"),
        pytest.param(stamped(0, 0.01), id="the computers' clock"),
        pytest.param(stamped(1), id="old images with their own stamps"),
    ],
)
def test_stamps_that_the_images_keep_to_are_right(data: Measured) -> None:
    before = fit_with_impacts(World(data, TRIGGERED), SPLIT)
    assert without_set_stamps(before, SPLIT) == (before, [])


def test_the_clock_of_the_computers_steps_against_the_stamps_just_so() -> None:
    step = set_stamps(stamped(0, 0.01).frames, 1000.0)
    assert step is not None
    assert step.step_s == pytest.approx(-0.01, abs=0.001)


@pytest.mark.parametrize(("step_s", "found"), [(0.0, False), (0.004, True)])
def test_stamps_that_are_rounded_otherwise_from_an_instant_on_are_of_no_clock_that_was_set(
    step_s: float, found: bool
) -> None:
    """A little later than before, they come to half a unit, which noise rounds up or down."""
    frames = set_by(step_s).frames
    half = np.where(np.arange(len(frames.counter)) >= FIRST, 0.5e-4, 0.0)
    noise = np.random.default_rng(2).normal(0.0, 1e-5, len(half))
    stamps = np.round(frames.started_s, 4) + np.round(frames.captured_s - frames.started_s + half + noise, 4)
    step = set_stamps(replace(frames, captured_s=stamps, started_s=np.round(frames.started_s, 4)), 1000.0)
    assert (step is not None) is found
