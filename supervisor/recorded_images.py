"""Images with the tracker's results, as messages of the supervisor's recording, and their replay."""

import base64
from dataclasses import dataclass
from math import isnan, nan

import cv2
import numpy as np

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.configuration import Configuration
from stillarm.common.files.typed_toml import parse_toml
from stillarm.common.recording.reader import Recording
from stillarm.common.recording.topics import ImageSample
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera import Frame
from stillarm.supervisor.step import Supervisor

_FAST_PNG = [cv2.IMWRITE_PNG_COMPRESSION, 1]


@dataclass
class ImageComparison:
    """Comparison of a replay of recorded images with the results of the live tracker.

    The tracker remembers earlier images. Once the recorder lost one, a replay cannot give the same numbers; images from
    there on are counted as not_compared.
    """

    frames: int = 0
    different: int = 0
    first_difference: str | None = None
    not_compared: int = 0


def image_sample(time_s: float, frame: Frame, sample: VisualSample, lost: int) -> ImageSample:
    """A frame and its visual sample as a message. lost: images tracked so far that were not recorded."""
    _, encoded = cv2.imencode(".png", frame.image, _FAST_PNG)
    return ImageSample(
        time_s,
        -1 if frame.counter is None else frame.counter,
        sample.started_cycle,
        nan if frame.stamp_s is None else frame.stamp_s,
        nan if frame.exposure_s is None else frame.exposure_s,
        sample.status,
        sample.displacement_x_px,
        sample.displacement_y_px,
        sample.rotation_rad,
        sample.features,
        sample.inliers,
        "png",
        base64.b64encode(encoded.tobytes()).decode("ascii"),
        lost,
    )


def recorded_frame(message: ImageSample) -> Frame:
    """The frame that a message holds. Raises UserError for an image that cannot be decoded."""
    data = np.frombuffer(base64.b64decode(message.data), np.uint8)
    image = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE) if len(data) else None
    if image is None:
        raise UserError(f"/images at {message.time_s} s: the image cannot be decoded; the file is damaged")
    return Frame(
        np.asarray(image, np.uint8),
        None if message.counter < 0 else message.counter,
        None if isnan(message.stamp_s) else message.stamp_s,
        None if isnan(message.exposure_s) else message.exposure_s,
    )


def compare_with_live(recording: Recording) -> ImageComparison:
    """Track the recorded images again, and compare every number with the live result, up to the first image that was
    tracked and not recorded."""
    text, name = recording.header.configuration, f"{recording.path} (configuration)"
    supervisor = Supervisor(parse_toml(text, Configuration, name).supervisor.tracker)
    comparison = ImageComparison()
    for message in recording.messages("/images"):
        if message.lost > 0:
            comparison.not_compared += 1
            continue
        found = supervisor.step(recorded_frame(message), message.started_cycle)
        comparison.frames += 1
        pairs = (
            ("status", message.status, found.status),
            ("displacement_px", message.displacement_px, found.displacement_x_px),
            ("displacement_y_px", message.displacement_y_px, found.displacement_y_px),
            ("rotation_rad", message.rotation_rad, found.rotation_rad),
            ("inliers", message.inliers, found.inliers),
        )
        different = [
            f"{key}: {was!r} live, {now!r} replayed" for key, was, now in pairs if not _same(was, now)
        ]
        if different:
            comparison.different += 1
            comparison.first_difference = (
                comparison.first_difference or f"frame {found.frame}, {different[0]}"
            )
    return comparison


def _same(was: float, now: float) -> bool:
    return was == now or (isnan(was) and isnan(now))
