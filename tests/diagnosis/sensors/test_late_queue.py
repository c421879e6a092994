"""A queue that holds more images than it did, of a triggered camera whose images are dated by their requests."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from stillarm.diagnosis.data.measured import Frames, Measured, dated_by_requests
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.events.impacts import fit_with_impacts
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.sensors.clocks import late_queue
from stillarm.diagnosis.sensors.clocks import without_old_images as _without_old_images
from tests.diagnosis.data.test_repeated_stamps import FIRST, PERIOD_S, SECONDS, TRIGGERED
from tests.fixtures.synthetic import NOISE, measured

SPLIT = interleaved(SECONDS)


def queued(later_s: float, wander_s: float = 0.002, older: int = 0) -> Measured:
    """Images of what was asked for, read `later_s` later from frame FIRST on; or images `older` frames old from
    there on, read in time. The delay wanders over a second."""
    data = measured(SECONDS, 3)
    random = np.random.default_rng(7)
    count = int((SECONDS - 0.4) * TRIGGERED.camera.frame_rate_hz)
    number = np.arange(count)
    asked = np.round((0.05 + number * PERIOD_S) / 1e-3) * 1e-3
    stay = float(np.exp(-PERIOD_S))
    wander = lfilter([wander_s * np.sqrt(1.0 - stay**2)], [1.0, -stay], random.standard_normal(count))
    late = np.where(number >= FIRST, later_s, 0.0)
    read = np.maximum.accumulate(asked + 0.1 + wander + late + random.normal(0.0, 0.001, count))
    shown = np.where(number >= FIRST, number - older, number)
    frames = Frames(number, read, asked, np.zeros(count), np.full(count, np.nan))
    world = World(dated_by_requests(replace(data, frames=replace(frames, started_s=asked[shown]))), TRIGGERED)
    vector = world.space.vector()
    vector[world.space.place["jump.0.0.q"]] = 0.02
    seen = world.predict(vector).channels["displacement"] + random.normal(0.0, NOISE["displacement"], count)
    return dated_by_requests(replace(data, frames=replace(frames, displacement_px=seen)))


@pytest.mark.slow
@pytest.mark.parametrize("longer", [1, 2])
def test_a_queue_that_holds_whole_frames_more_is_found(longer: int) -> None:
    before = fit_with_impacts(World(queued(longer * PERIOD_S), TRIGGERED), SPLIT)
    held = late_queue(before)
    assert held is not None
    assert abs(held.first - FIRST) <= 1 and held.frames == longer
    baseline, laws = _without_old_images(before, SPLIT)
    assert laws[0].cause == "stale_frame_buffer" and laws[0].values["frames"][0] == longer
    assert laws[0].values["onset_s"][0] == pytest.approx(0.05 + FIRST * PERIOD_S, abs=1.5 * PERIOD_S)
    assert float(laws[0].held_out_score.sum()) > 25.0
    late = baseline.world.channels["arrival"] - baseline.predicted.channels["arrival"]
    step = float(np.median(late[FIRST : FIRST + 20]) - np.median(late[FIRST - 20 : FIRST]))
    assert abs(step) < 0.25 * PERIOD_S


@pytest.mark.slow
@pytest.mark.parametrize(
    ("later_s", "wander_s", "older"),
    [
        pytest.param(0.0, 0.002, 0, id="nothing"),
        pytest.param(0.0, 0.008, 0, id="a delay that wanders"),
        pytest.param(1.5 * PERIOD_S, 0.001, 0, id="a step of no whole frames"),
        pytest.param(-PERIOD_S, 0.002, 0, id="a shorter queue"),
        pytest.param(0.0, 0.002, 1, id="old images that are read in time"),
    ],
)
def test_nothing_else_is_such_a_queue(later_s: float, wander_s: float, older: int) -> None:
    assert late_queue(fit_with_impacts(World(queued(later_s, wander_s, older), TRIGGERED), SPLIT)) is None


def stamped(later_s: float, set_by_s: float = 0.0) -> Measured:
    """The same images with the camera's own stamps. set_by_s: by which the controller's clock is set on at FIRST."""
    data = queued(later_s)
    asked = data.frames.started_s
    stamps = asked + 433.2 + np.random.default_rng(8).normal(0.0, 3e-4, len(asked))
    on = np.where(np.arange(len(asked)) >= FIRST, set_by_s, 0.0)
    frames = replace(
        data.frames,
        asked=False,
        captured_s=stamps,
        started_s=asked + on,
        received_s=data.frames.received_s + on,
    )
    return replace(data, frames=frames)


@pytest.mark.slow
@pytest.mark.parametrize(("later_s", "set_by_s", "found"), [(PERIOD_S, 0.0, True), (0.0, PERIOD_S, False)])
def test_requests_tell_a_stamped_cameras_queue_from_a_clock_that_was_set(
    later_s: float, set_by_s: float, found: bool
) -> None:
    before = fit_with_impacts(World(stamped(later_s, set_by_s), TRIGGERED), SPLIT)
    assert (late_queue(before) is not None) is found
