"""Frames that only seemed to be lost."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.sensors.image_dating import image_nats, recounted
from tests.fixtures.synthetic import MODEL, fitted, measured

SECONDS = 10.0
PERIOD_S = 1.0 / MODEL.camera.frame_rate_hz


def _late_from(frame: int) -> Measured:
    """All frames from that one on come a period later than those before, and none was lost."""
    data = measured(SECONDS, 5)
    late = np.where(np.arange(len(data.frames)) >= frame, PERIOD_S, 0.0)
    f = data.frames
    return replace(data, frames=replace(f, received_s=f.received_s + late, started_s=f.started_s + late))


@pytest.mark.slow
@pytest.mark.parametrize("frame", [120, 300, 480])
def test_images_tell_that_no_frame_was_lost_where_arrivals_say_so(frame: int) -> None:
    split = interleaved(SECONDS)
    misled = fitted(_late_from(frame), split=split)
    assert misled.world.frame_clock.lost == 1
    mended = recounted(misled, split)
    assert mended.world.frame_clock.lost == 0
    assert image_nats(mended) > image_nats(misled) + 100.0


def _lost_at(frame: int, many: int) -> Measured:
    """So many frames never came, and the counter counts arrivals."""
    data = measured(SECONDS, 5)
    f, kept = data.frames, np.delete(np.arange(len(data.frames)), range(frame, frame + many))
    shown = replace(
        f, counter=np.arange(len(kept)), received_s=f.received_s[kept], started_s=f.started_s[kept],
        displacement_px=f.displacement_px[kept], captured_s=f.captured_s[kept],
    )  # fmt: skip
    return replace(data, frames=shown)


def test_a_frame_that_was_lost_stays_lost() -> None:
    split = interleaved(SECONDS)
    last = fitted(_lost_at(300, 1), split=split)
    assert last.world.frame_clock.lost == 1
    assert recounted(last, split).world is last.world


@pytest.mark.slow
@pytest.mark.parametrize("frame", [120, 300, 480])
@pytest.mark.parametrize("many", [2, 5])
def test_images_tell_how_many_were_lost_where_arrivals_look_as_if_a_clock_was_set(
    frame: int, many: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    split = interleaved(SECONDS)
    with monkeypatch.context() as patch:
        patch.setattr(
            "stillarm.diagnosis.data.frame_clock.lost_before",
            lambda times, *_: np.zeros(len(times), np.int64),
        )
        misled = fitted(_lost_at(frame, many), split=split)
    assert misled.world.frame_clock.lost == 0
    mended = recounted(misled, split)
    assert mended.world.frame_clock.lost == many
    assert image_nats(mended) > image_nats(misled) + 100.0


def test_a_clock_that_was_set_lost_no_frame() -> None:
    data = measured(SECONDS, 5)
    f, set_s = data.frames, 4.4 * PERIOD_S * (np.arange(len(data.frames)) >= 300)
    late = replace(f, counted=True, received_s=f.received_s + set_s, started_s=f.started_s + set_s)
    split = interleaved(SECONDS)
    last = fitted(replace(data, frames=late), split=split)
    assert last.world.frame_clock.lost == 0
    assert recounted(last, split).world is last.world


def test_what_the_counter_itself_says_was_lost_is_believed() -> None:
    data = _late_from(300)
    counter = data.frames.counter + (np.arange(len(data.frames)) >= 300)
    split = interleaved(SECONDS)
    last = fitted(replace(data, frames=replace(data.frames, counter=counter)), split=split)
    assert recounted(last, split).world is last.world
