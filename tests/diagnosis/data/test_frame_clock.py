"""Which exposure each frame was, from counters that count exposures, arrivals, or were set back."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from stillarm.common.files.model import Camera, Model
from stillarm.diagnosis.data.frame_clock import exposure_counts, frame_clock
from stillarm.diagnosis.data.measured import Frames

RATE = 65.0
MODEL = Model(camera=Camera(frame_rate_hz=RATE))


def frames(counter: NDArray[np.int64], exposed: NDArray[np.int64], **more: NDArray[np.float64]) -> Frames:
    """Frames of these exposures, read 74 to 76 ms after each, with these counters."""
    late = np.random.default_rng(4).uniform(0.074, 0.076, len(exposed))
    received = exposed / RATE + late
    nothing = np.full(len(exposed), np.nan)
    return Frames(counter, received, received - 0.1, nothing, more.get("captured_s", nothing))


def test_a_counter_of_exposures_tells_of_every_loss() -> None:
    exposed = np.delete(np.arange(400), [50, 51, 52, 200, 333])
    clock = frame_clock(frames(exposed.copy(), exposed), MODEL)
    assert clock.lost == 5
    assert clock.exposed == 400
    assert clock.counted
    assert np.diff(clock.grid_s) == pytest.approx(np.diff(exposed) / RATE)


@pytest.mark.parametrize("lost", [[100], [100, 101, 102], [60, 200, 330]])
@pytest.mark.slow
def test_a_counter_of_arrivals_is_mended_by_the_arrivals(lost: list[int]) -> None:
    exposed = np.delete(np.arange(400), lost)
    counts = exposure_counts(frames(np.arange(len(exposed)), exposed), 1.0 / RATE)
    assert np.array_equal(counts - counts[0], exposed - exposed[0])


@pytest.mark.parametrize("last", [1, 3])
def test_stamps_tell_of_a_loss_just_before_the_end(last: int) -> None:
    """Of one late frame the arrivals alone cannot say more than that it is late."""
    exposed = np.delete(np.arange(400), [100, *range(399 - last - 4, 400 - last)])
    stamped = frames(np.arange(len(exposed)), exposed, captured_s=exposed / RATE + 5.0)
    counts = exposure_counts(stamped, 1.0 / RATE)
    assert np.array_equal(counts - counts[0], exposed - exposed[0])


def test_stamps_that_step_by_themselves_are_a_clock_that_was_set_and_no_loss() -> None:
    """By five whole frames, which the arrivals know nothing of."""
    exposed = np.arange(400)
    stamps = exposed / RATE + np.where(exposed > 200, 5.0 / RATE, 0.0)
    counts = exposure_counts(frames(exposed.copy(), exposed, captured_s=stamps), 1.0 / RATE)
    assert np.array_equal(counts, exposed)


@pytest.mark.parametrize("lost", [[], [100], [60, 200, 201, 330]])
def test_where_arrivals_scatter_by_more_than_a_period_the_instants_at_which_frames_were_begun_tell(
    lost: list[int],
) -> None:
    exposed = np.delete(np.arange(400), lost)
    some = frames(np.arange(len(exposed)), exposed)
    late = np.random.default_rng(6).normal(0.0, 1.2 / RATE, len(exposed))
    blurred = replace(
        some,
        received_s=np.maximum.accumulate(some.received_s + late),
        started_s=np.floor(1000.0 * exposed / RATE) / 1000.0,
    )
    counts = exposure_counts(blurred, 1.0 / RATE)
    assert np.array_equal(counts - counts[0], exposed - exposed[0])


def test_a_supervisor_that_waits_for_its_first_frame_has_lost_none() -> None:
    """Each frame is begun as the one before has come, but the first whenever the supervisor is."""
    exposed = np.arange(400)
    some = frames(exposed, exposed)
    received = some.received_s + np.random.default_rng(6).normal(0.0, 0.2 / RATE, len(exposed))
    began = some.received_s - 1.0 / RATE
    began[0] -= 2.0 / RATE
    counts = exposure_counts(replace(some, received_s=received, started_s=began), 1.0 / RATE)
    assert np.array_equal(counts - counts[0], exposed)


def test_a_counter_that_was_set_back_goes_on_by_the_arrivals() -> None:
    exposed = np.arange(300)
    counter = np.where(exposed < 150, exposed + 5000, exposed - 150)
    counts = exposure_counts(frames(counter, exposed), 1.0 / RATE)
    assert np.array_equal(np.diff(counts), np.ones(299))


@pytest.mark.parametrize("length", [10, 40])
def test_late_frames_are_no_losses(length: int) -> None:
    exposed = np.arange(300)
    some = frames(exposed.copy(), exposed)
    some.received_s[100 : 100 + length] += 0.06  # a burst, not a loss: what follows is on time again
    assert np.array_equal(exposure_counts(some, 1.0 / RATE), exposed)


def test_a_triggered_camera_has_its_stamps_for_a_grid_or_else_its_arrivals() -> None:
    model = msgspec.structs.replace(MODEL, camera=msgspec.structs.replace(MODEL.camera, mode="triggered"))
    exposed = np.arange(200)
    stamped = frame_clock(frames(exposed, exposed, captured_s=900.0 + exposed / RATE), model)
    assert not stamped.arrival
    assert np.diff(stamped.grid_s) == pytest.approx(np.full(199, 1.0 / RATE))
    bare = frame_clock(frames(exposed, exposed), model)
    assert bare.arrival


def test_a_triggered_camera_can_be_dated_by_when_each_frame_was_asked_for() -> None:
    model = msgspec.structs.replace(MODEL, camera=msgspec.structs.replace(MODEL.camera, mode="triggered"))
    exposed = np.arange(200)
    bare = frames(exposed, exposed)
    asked = Frames(
        bare.counter, bare.received_s, exposed / RATE, bare.displacement_px, exposed / RATE, asked=True
    )
    clock = frame_clock(asked, model)
    assert not clock.arrival
    assert not clock.counted
    assert np.diff(clock.grid_s) == pytest.approx(np.full(199, 1.0 / RATE))


@pytest.mark.parametrize("step_s", [0.0, 0.034, -0.02])
def test_stamps_of_another_quartz_are_told_in_the_controllers_time(step_s: float) -> None:
    random = np.random.default_rng(3)
    count = 900
    begun = np.arange(count) / 30.0 + random.uniform(0.0, 0.001, count)
    stamps = (begun + 283.0) * (1.0 + 40e-6)
    late = np.where(begun > 12.0, step_s, 0.0)
    noted = np.floor((begun + late) / 0.001) * 0.001
    frames = Frames(np.arange(count), noted + 0.1, noted, np.zeros(count), stamps)
    clock = frame_clock(frames, Model(camera=Camera(mode="triggered", frame_rate_hz=30.0)))
    assert not clock.counted
    assert not clock.arrival
    off = clock.grid_s - begun
    assert np.ptp(off) < 1.5e-4  # without: 1.2 ms
