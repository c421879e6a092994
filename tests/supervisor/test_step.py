"""The supervisor's step: frame and timestamp in, visual sample out."""

from math import isnan

import numpy as np

from stillarm.common.datagrams.visual_sample import TrackingStatus
from stillarm.common.files.configuration import Tracker
from stillarm.drivers.cameras.camera import Frame
from stillarm.supervisor.step import Supervisor
from tests.fixtures.sinusoid_scene import SinusoidScene, photographed

SHAPE = (96, 128)


def test_counts_arrivals_and_carries_what_the_camera_says():
    scene, random = SinusoidScene(1), np.random.default_rng(0)
    supervisor = Supervisor(Tracker())
    first = supervisor.step(Frame(photographed(scene.at(0, 0, shape=SHAPE), random), None, None, None), -1)
    assert (first.frame, first.started_cycle, first.displacement_x_px) == (0, -1, 0.0)
    assert isnan(first.captured_s) and isnan(first.exposure_s)
    image = photographed(scene.at(1.5, -0.5, shape=SHAPE), random)
    second = supervisor.step(Frame(image, None, 12.5, 0.015), 4711)
    assert (second.frame, second.started_cycle, second.captured_s, second.exposure_s) == (
        1,
        4711,
        12.5,
        0.015,
    )
    assert second.measured and abs(second.displacement_x_px - 1.5) < 0.05
    assert 0.0 < second.variance_x_px2 < 0.01 and second.inliers >= 12
    assert supervisor.step(Frame(image, 77, None, None), 4712).frame == 77


def test_a_bad_frame_carries_no_number():
    supervisor = Supervisor(Tracker())
    sample = supervisor.step(Frame(np.zeros(SHAPE, np.uint8), 5, 1.0, 0.01), 9)
    assert (sample.frame, sample.started_cycle, sample.status) == (5, 9, TrackingStatus.DARK)
    assert isnan(sample.displacement_x_px) and isnan(sample.variance_x_px2)
    assert (sample.captured_s, sample.exposure_s) == (1.0, 0.01)


def test_restart_takes_a_new_origin():
    scene, random = SinusoidScene(2), np.random.default_rng(0)
    supervisor = Supervisor(Tracker())
    for x in (0.0, 2.0):
        sample = supervisor.step(
            Frame(photographed(scene.at(x, 0, shape=SHAPE), random), None, None, None), 1
        )
    assert abs(sample.displacement_x_px - 2.0) < 0.05
    supervisor.restart()
    again = supervisor.step(Frame(photographed(scene.at(2, 0, shape=SHAPE), random), None, None, None), 2)
    assert again.displacement_x_px == 0.0
