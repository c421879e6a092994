"""Old images that a buffer hands over with their own stamps."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from stillarm.diagnosis.data.frame_times import held_back
from stillarm.diagnosis.data.measured import Frames, Measured
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.events.impacts import fit_with_impacts
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.sensors.clocks import without_old_images as _without_old_images
from tests.fixtures.synthetic import MODEL, NOISE, measured

SECONDS, FIRST, PERIOD_S = 10.0, 250, 1.0 / MODEL.camera.frame_rate_hz
SPLIT = interleaved(SECONDS)
TRIGGERED = msgspec.structs.replace(MODEL, camera=msgspec.structs.replace(MODEL.camera, mode="triggered"))


def stamped(older: int, clock_step_s: float = 0.0) -> Measured:
    """From frame FIRST on images and stamps are `older` exposures old; or the frames' clock steps there."""
    data = measured(SECONDS, 3)
    random = np.random.default_rng(5)
    count = int((SECONDS - 0.4) * MODEL.camera.frame_rate_hz)
    number = np.arange(count)
    begun = 0.05 + number * PERIOD_S + random.uniform(0.0, 0.001, count)
    read = np.maximum.accumulate(begun + 0.1 + random.normal(0.0, 0.002, count))
    shown = np.where(number >= FIRST, number - older, number)
    taken = begun[shown] + random.normal(0.0, 1e-5, count)
    world = World(replace(data, frames=Frames(number, read, begun, np.zeros(count), taken)), TRIGGERED)
    vector = world.space.vector()
    vector[world.space.place["jump.0.0.q"]] = 0.02
    seen = world.predict(vector).channels["displacement"] + random.normal(0.0, NOISE["displacement"], count)
    late = np.where(number >= FIRST, clock_step_s, 0.0)
    return replace(data, frames=Frames(number, read + late, begun + late, seen, taken + 283.0))


@pytest.mark.slow
@pytest.mark.parametrize("older", [1, 3])
def test_an_exposure_that_comes_twice_tells_of_the_buffer(older: int) -> None:
    data = stamped(older)
    held = held_back(data.frames, PERIOD_S)
    assert held is not None
    assert (held.first, held.frames) == (FIRST, older)
    baseline, laws = _without_old_images(fit_with_impacts(World(data, TRIGGERED), SPLIT), SPLIT)
    assert laws[0].values["frames"][0] == older
    assert float(laws[0].held_out_score.sum()) > 10.0
    late = baseline.world.channels["arrival"] - baseline.predicted.channels["arrival"]
    assert abs(float(np.median(late[:FIRST]) - np.median(late[FIRST:]))) < 0.1 * PERIOD_S


def test_a_clock_that_was_set_repeats_no_stamp() -> None:
    assert held_back(stamped(0, PERIOD_S).frames, PERIOD_S) is None
    assert held_back(stamped(0).frames, PERIOD_S) is None
