"""Key frames: handed over without a step, found again."""

import numpy as np
import pytest

from stillarm.common.datagrams.visual_sample import TrackingStatus
from tests.fixtures.sinusoid_scene import SinusoidScene
from tests.fixtures.tracked_scenes import move, tracked


@pytest.mark.slow
def test_fast_move_and_back_gives_the_same_number():
    there = move(520.0, 0.6, 54)
    truth = np.concatenate([there, there[::-1]])
    error, results, tracker = tracked(truth, SinusoidScene(5))
    assert all(r.status == TrackingStatus.MEASURED for r in results)
    assert tracker.key_frames >= 2
    assert np.abs(error[:, :2]).max() < 0.05
    assert np.abs(error[-5:, :2]).max() < 0.01  # on the first key frame again


@pytest.mark.slow
def test_handover_makes_no_step():
    error, _, tracker = tracked(move(300.0, 0.8, 68), SinusoidScene(6))
    assert tracker.key_frames >= 2
    assert np.abs(np.diff(error[:, 0])).max() < 0.03
