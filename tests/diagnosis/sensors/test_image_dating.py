"""By which clock a triggered camera's images are dated."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from scipy.signal import lfilter

from stillarm.diagnosis.data.measured import Frames, Measured, dated_by_requests
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision.explain import explain
from stillarm.diagnosis.events.impacts import fit_with_impacts
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import make_data
from stillarm.diagnosis.fitting.rest import rest_of
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.sensors.image_dating import dated, dated_anew
from tests.fixtures.synthetic import MODEL, NOISE, measured

SECONDS, ONSET_S, STEP_S, SPREAD_S = 12.0, 4.4, 0.034, 0.006
WANDER_S = 1.0
DIM_PX = 0.6
TILT = "camera.rotation_px_per_rad"
SPLIT = interleaved(SECONDS)
TRIGGERED = msgspec.structs.replace(
    MODEL,
    camera=msgspec.structs.replace(MODEL.camera, mode="triggered"),
    timing=msgspec.structs.replace(MODEL.timing, capture_delay_std_s=SPREAD_S),
)


DIM = msgspec.structs.replace(
    TRIGGERED, camera=msgspec.structs.replace(TRIGGERED.camera, noise_std_px=DIM_PX)
)


def triggered(step_s: float, noted_s: float = 0.0, held: int = 0, tilt: float = 0.0) -> Measured:
    """Images exposed when they were asked for, read a scattering time later; the frames' clock steps at ONSET_S.

    noted_s: requests are noted to so much. held: from then on images are so many frames older, while the delay wanders
    slowly instead of scattering, and images are dim. tilt: of the camera, px/rad.
    """
    data = measured(SECONDS, 3)
    random = np.random.default_rng(5)
    count = int((SECONDS - 0.4) * TRIGGERED.camera.frame_rate_hz)
    number = np.arange(count)
    begun = 0.05 + number / TRIGGERED.camera.frame_rate_hz + random.uniform(0.0, 0.001, count)
    late = random.normal(0.0, SPREAD_S, count)
    if held:
        stay = 1.0 - 1.0 / (WANDER_S * TRIGGERED.camera.frame_rate_hz)
        late = lfilter([(1.0 - stay**2) ** 0.5], [1.0, -stay], late)
    read = np.maximum.accumulate(begun + 0.1 + late)
    none = np.full(count, np.nan)
    asked = dated_by_requests(replace(data, frames=Frames(number, read, begun, np.zeros(count), none)))
    world = World(asked, TRIGGERED)
    vector = world.space.vector()
    vector[world.space.place["jump.0.0.q"]] = 0.02
    vector[world.space.place[TILT]] += tilt
    if held:
        vector[world.space.place["timing.stale_onset_s"]] = ONSET_S
        vector[world.space.place["timing.stale_frames"]] = held
    noise_px = DIM_PX if held else NOISE["displacement"]
    seen = world.predict(vector).channels["displacement"] + random.normal(0.0, noise_px, count)
    set_on = np.where(begun >= ONSET_S, step_s, 0.0)
    if noted_s:
        begun = np.floor(begun / noted_s) * noted_s
    return replace(data, frames=Frames(number, read + set_on, begun + set_on, seen, none))


@pytest.mark.slow
def test_requests_date_the_images_although_their_clock_was_set() -> None:
    for step_s in (0.0, STEP_S):
        last = dated(fit_with_impacts(World(triggered(step_s), TRIGGERED), SPLIT), SPLIT)
        assert last.world.measured.frames.asked, f"a step of {step_s} s"


@pytest.mark.slow
@pytest.mark.parametrize("held", [1, 3])
def test_requests_date_the_images_although_a_buffer_hands_over_old_ones(held: int) -> None:
    """They arrive as they always did: dated by that, the delay's wander would take up what they show."""
    last = dated(fit_with_impacts(World(triggered(0.0, 0.001, held), DIM), SPLIT), SPLIT)
    assert last.world.measured.frames.asked


@pytest.mark.slow
def test_old_images_are_no_clock_that_was_set_where_the_requests_go_on_evenly() -> None:
    rivals = ["clock_step", "stale_frame_buffer"]
    old = dated(fit_with_impacts(World(triggered(0.0, 0.001, 1), DIM), SPLIT), SPLIT)
    assert [one.cause for one in explain(old, SPLIT, only=rivals).findings] == ["stale_frame_buffer"]
    step = dated(fit_with_impacts(World(triggered(0.5 / 65.0, 0.001), TRIGGERED), SPLIT), SPLIT)
    assert [one.cause for one in explain(step, SPLIT, only=rivals).findings] == ["clock_step"]


@pytest.mark.slow
def test_doubt_of_instants_excuses_no_more_than_the_delay_scatters() -> None:
    for step_s, excused in ((0.0, True), (STEP_S, False)):
        last = fit_with_impacts(World(triggered(step_s), TRIGGERED), SPLIT)  # dated by arrivals
        assert rest_of(last, "displacement", SPLIT).immaterial is excused


def test_requests_noted_to_the_cycle_are_no_discovery() -> None:
    last = fit_with_impacts(World(dated_by_requests(triggered(0.0, 0.001)), TRIGGERED), SPLIT)
    assert rest_of(last, "displacement", SPLIT).immaterial
    assert last.sigma["displacement"] < 1.2 * NOISE["displacement"]


@pytest.mark.slow
def test_images_are_dated_anew_beside_what_was_found_in_them() -> None:
    """Told wrongly by far more than an instant's doubt, they fit by no dating."""
    data = triggered(0.0, tilt=4000.0)
    baseline = fit_with_impacts(World(data, TRIGGERED), SPLIT)
    start = baseline.world.space.with_values(baseline.vector, {TILT: 4000.0})
    found = fit(make_data(baseline.world, SPLIT), start, (*baseline.free, TILT))
    anew = dated_anew(baseline, found, SPLIT)
    assert anew is not None and anew.world.measured.frames.asked
    assert anew.value(TILT) == 0.0  # the baseline's: nothing is found in it
    assert dated_anew(anew, anew, SPLIT) is None
