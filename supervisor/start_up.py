"""Preparations before the first frame is announced: empty the camera's queue, and run every slow first call."""

import time
from collections.abc import Callable

import numpy as np

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.drivers.cameras.camera import Camera, Frame
from stillarm.supervisor.recorded_images import image_sample

_QUEUED_WITHIN_S = 0.002  # a frame that read() returns sooner was queued: a camera's period is longer
_MOST_QUEUED = 64  # more than any driver queues; do not wait for a camera that delivers faster
_FRAME_TIMEOUT_S = 0.1


def discard_queued(camera: Camera, clock: Callable[[], float] = time.monotonic) -> int:
    """Take frames until a read has to wait, so that the next frame is fresh. Returns the number of frames taken.

    While a driver starts and the tracker warms up, frames gather in the driver's queue. If they were announced, the
    estimate of the capture delay would begin with frames that are older than any later one. Do not use it on files,
    which deliver each frame once. Raises EndOfStream.
    """
    for taken in range(_MOST_QUEUED):
        asked = clock()
        if camera.read(_FRAME_TIMEOUT_S) is None:
            return taken
        if clock() - asked > _QUEUED_WITHIN_S:
            return taken + 1
    return _MOST_QUEUED


def warm_up_recording(width_px: int, height_px: int) -> None:
    """Encode one blank image as the recorder's messages hold it: PNG's first call takes some milliseconds."""
    image = np.zeros((height_px, width_px), np.uint8)
    image_sample(0.0, Frame(image, None, None, None), VisualSample(0, -1, 0), lost=0)
