"""Requests off their interval."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.data.frame_times import missing_requests, request_intervals
from stillarm.diagnosis.data.measured import Frames
from tests.fixtures.synthetic import measured


def test_a_clock_that_was_set_stands_out_of_the_requests_intervals() -> None:
    """By the step, at the request after it, over no less than a cycle."""
    data = measured(4.0, 1, {})
    started = 0.015 * np.arange(len(data.frames))
    started[100:] += 0.08
    found = request_intervals(replace(data, frames=replace(data.frames, started_s=started)))
    assert int(np.argmax(np.abs(found.off_s))) == 99
    assert found.off_s[99] == pytest.approx(0.08)
    assert found.usual_s == pytest.approx(data.cycle_s)


LOST = [20, 21, 90, 150]


def _asked(scatter: float, counted: bool) -> Frames:
    frames = measured(4.0, 1).frames
    asked = np.delete(np.arange(len(frames) + len(LOST)), LOST)
    started = 0.015 * (asked + scatter * np.random.default_rng(4).standard_normal(len(asked)))
    counter = asked if counted else np.arange(len(asked))
    return replace(
        frames, counter=counter, started_s=started, received_s=started + 0.07,
        captured_s=np.full(len(asked), np.nan),
    )  # fmt: skip


@pytest.mark.parametrize(("scatter", "counted"), [(0.02, False), (0.02, True), (0.4, True)])
def test_frames_that_a_triggered_camera_lost_are_missing_from_its_requests(
    scatter: float, counted: bool
) -> None:
    missing = missing_requests(_asked(scatter, counted))
    assert missing is not None
    assert missing.sum() == len(LOST)
    assert missing[19] == 2


def test_requests_that_keep_no_interval_tell_of_no_loss() -> None:
    assert missing_requests(_asked(0.4, counted=False)) is None
