"""By which clock a triggered camera's images are dated."""

from dataclasses import replace

import msgspec
import numpy as np

from diagnosis.diagnose import _dated
from diagnosis.fit import make_data
from diagnosis.impacts import fit_with_impacts
from diagnosis.measured import Frames, Measured, dated_by_requests
from diagnosis.split import interleaved
from diagnosis.structure import examine
from diagnosis.world import World
from tests.diagnosis.synthetic import MODEL, NOISE, measured

SECONDS, ONSET_S, STEP_S, SPREAD_S = 12.0, 4.4, 0.034, 0.006
SPLIT = interleaved(SECONDS)
TRIGGERED = msgspec.structs.replace(
    MODEL,
    camera=msgspec.structs.replace(MODEL.camera, mode="triggered"),
    timing=msgspec.structs.replace(MODEL.timing, capture_delay_std_s=SPREAD_S),
)


def triggered(step_s: float, noted_s: float = 0.0) -> Measured:
    """Images exposed when they were asked for, read a scattering time later; the frames' clock steps at ONSET_S.

    noted_s: requests are noted to so much.
    """
    data = measured(SECONDS, 3)
    random = np.random.default_rng(5)
    count = int((SECONDS - 0.4) * TRIGGERED.camera.frame_rate_hz)
    number = np.arange(count)
    begun = 0.05 + number / TRIGGERED.camera.frame_rate_hz + random.uniform(0.0, 0.001, count)
    read = np.maximum.accumulate(begun + 0.1 + random.normal(0.0, SPREAD_S, count))
    none = np.full(count, np.nan)
    asked = dated_by_requests(replace(data, frames=Frames(number, read, begun, np.zeros(count), none)))
    world = World(asked, TRIGGERED)
    vector = world.space.vector()
    vector[world.space.place["jump.0.0.q"]] = 0.02
    seen = world.predict(vector).channels["displacement"] + random.normal(0.0, NOISE["displacement"], count)
    late = np.where(begun >= ONSET_S, step_s, 0.0)
    if noted_s:
        begun = np.floor(begun / noted_s) * noted_s
    return replace(data, frames=Frames(number, read + late, begun + late, seen, none))


def test_requests_date_the_images_although_their_clock_was_set() -> None:
    for step_s in (0.0, STEP_S):
        last = _dated(fit_with_impacts(World(triggered(step_s), TRIGGERED), SPLIT), SPLIT)
        assert last.world.measured.frames.asked, f"a step of {step_s} s"


def test_doubt_of_instants_excuses_no_more_than_the_delay_scatters() -> None:
    for step_s, excused in ((0.0, True), (STEP_S, False)):
        last = fit_with_impacts(World(triggered(step_s), TRIGGERED), SPLIT)  # dated by arrivals
        assert examine(make_data(last.world, SPLIT), last).channels["displacement"].white is excused


def test_requests_noted_to_the_cycle_are_no_discovery() -> None:
    last = fit_with_impacts(World(dated_by_requests(triggered(0.0, 0.001)), TRIGGERED), SPLIT)
    assert examine(make_data(last.world, SPLIT), last).channels["displacement"].white
    assert last.sigma["displacement"] < 1.2 * NOISE["displacement"]
