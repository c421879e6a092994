"""A buffer that holds one more image is a step of the delay by one frame: told as a class of both."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision.decide import class_of
from stillarm.diagnosis.decision.explain import explain
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.queued_images import FORM
from tests.fixtures.synthetic import MODEL, fitted, measured

SECONDS, ONSET_S = 24.0, 11.0
FRAME_S = 1.0 / MODEL.camera.frame_rate_hz
BOTH = ["clock_step", "stale_frame_buffer"]


def late_from_onset(step_s: float, stamped: bool = False) -> Fit:
    data = measured(SECONDS, 1)
    received = data.frames.received_s + step_s * (data.frames.received_s > ONSET_S)
    captured = data.frames.received_s + 30.0 if stamped else data.frames.captured_s
    return fitted(replace(data, frames=replace(data.frames, received_s=received, captured_s=captured)))


@pytest.mark.slow
def test_a_step_by_a_frame_is_told_as_a_class() -> None:
    found = explain(late_from_onset(FRAME_S), interleaved(SECONDS), only=BOTH)
    first = found.findings[0]
    assert {first.cause, *class_of(found, first)} == set(BOTH)
    queued = next(one for one in found.stages[0].candidates if one.cause == "stale_frame_buffer")
    assert queued.values["frames"][0] == 1.0
    assert queued.values["onset_s"][0] == pytest.approx(ONSET_S, abs=2.0 * FRAME_S)


@pytest.mark.slow
def test_a_step_by_half_a_frame_more_is_a_clock_s() -> None:
    found = explain(late_from_onset(1.5 * FRAME_S), interleaved(SECONDS), only=BOTH)
    assert [one.cause for one in found.findings] == ["clock_step"]
    assert class_of(found, found.findings[0]) == []


def test_stamps_tell_the_two_apart() -> None:
    assert not FORM.cause.needs(late_from_onset(FRAME_S, stamped=True).world)
    assert np.isnan(late_from_onset(FRAME_S).world.measured.frames.captured_s).all()
