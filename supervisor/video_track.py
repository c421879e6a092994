"""Any video through the tracker: frames in, visual samples out, with the rate at which they were filmed.

A file says at which rate it plays, which need not be that at which it was filmed (high-speed video plays slowly).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite, isnan
from pathlib import Path

import cv2
import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from stillarm.common.datagrams.visual_sample import TrackingStatus, VisualSample
from stillarm.common.files.configuration import Tracker
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera import EndOfStream, Frame
from stillarm.drivers.cameras.file_camera import FileCamera
from stillarm.drivers.cameras.raw_video import read_header
from stillarm.supervisor.step import Supervisor

SMALLEST_REGION_PX = 16
COLUMNS = (
    "frame,received_s,displacement_px,captured_s,features,inliers,displacement_y_px,rotation_rad,"
    "variance_x_px2,variance_y_px2,variance_rotation_rad2,status"
)
_MIN_SPECTRUM = 32  # frames: fewer say nothing about a frequency


@dataclass(frozen=True)
class Region:
    """A part of the image: px from its left and upper edge."""

    x: int
    y: int
    width: int
    height: int


@dataclass(frozen=True)
class VideoSummary:
    """What one line tells. rms, span: of the displacement along the axis that moves more, px; hz: its largest line."""

    frames: int
    measured: int
    axis: str
    rms_px: float
    span_px: float
    frequency_hz: float


def stated_rate_hz(path: Path) -> float | None:
    """The rate that a file states: that of a .cih is the recording's, that of a video the playing rate. None: none."""
    if path.is_dir():
        return None
    if path.suffix.lower() in (".cih", ".mraw"):
        return read_header(path.with_suffix(".cih")).rate_hz or None
    capture = cv2.VideoCapture(str(path))
    try:
        rate = float(capture.get(cv2.CAP_PROP_FPS))
    finally:
        capture.release()
    return rate if isfinite(rate) and 0.0 < rate < 1e6 else None


def stated_frames(path: Path) -> int:
    """How many frames a file says it has; 0 where it does not say."""
    if path.is_dir():
        return sum(1 for _ in path.iterdir())
    if path.suffix.lower() in (".cih", ".mraw"):
        return read_header(path.with_suffix(".cih")).frames
    capture = cv2.VideoCapture(str(path))
    try:
        return max(0, int(capture.get(cv2.CAP_PROP_FRAME_COUNT)))
    finally:
        capture.release()


def tracked(path: Path, config: Tracker, region: Region | None, shrink: int = 1) -> Iterator[VisualSample]:
    """A visual sample for each frame; its frame counts from 0. Raises UserError for what is no video.

    shrink: factor by which images are reduced first, by the mean of each block. Fast and smeared motion of a large
    image is found in the small one. Displacements are in px of the file's own image all the same.
    """
    camera, supervisor = FileCamera(path, str(path)), Supervisor(config)
    camera.start()
    try:
        while True:
            try:
                frame = camera.read(0.0)
            except EndOfStream:
                return
            if frame is not None:
                sample = supervisor.step(_reduced(_cropped(frame, region, path), shrink), -1)
                yield _enlarged(sample, shrink) if shrink > 1 else sample
    finally:
        camera.close()


def _cropped(frame: Frame, region: Region | None, path: Path) -> Frame:
    if region is None or frame.image is None:
        return frame
    height, width = frame.image.shape
    if region.x + region.width > width or region.y + region.height > height:
        raise UserError(
            f"--region {region.x}:{region.y}:{region.width}:{region.height}: beyond the image of {path}, which is "
            f"{width} x {height} px"
        )
    part = frame.image[region.y : region.y + region.height, region.x : region.x + region.width]
    return Frame(np.ascontiguousarray(part), frame.counter, frame.stamp_s, frame.exposure_s)


def _reduced(frame: Frame, shrink: int) -> Frame:
    if shrink == 1 or frame.image is None:
        return frame
    height, width = (side // shrink for side in frame.image.shape)
    whole = frame.image[: height * shrink, : width * shrink]
    small = cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA)
    return Frame(np.asarray(small, np.uint8), frame.counter, frame.stamp_s, frame.exposure_s)


def _enlarged(sample: VisualSample, shrink: int) -> VisualSample:
    """A sample of a reduced image in px of the whole one."""
    return structs.replace(
        sample,
        displacement_x_px=shrink * sample.displacement_x_px,
        displacement_y_px=shrink * sample.displacement_y_px,
        variance_x_px2=shrink**2 * sample.variance_x_px2,
        variance_y_px2=shrink**2 * sample.variance_y_px2,
        covariance_xy_px2=shrink**2 * sample.covariance_xy_px2,
    )


def csv_row(sample: VisualSample, rate_hz: float) -> str:
    """A line of frames.csv; an empty field is no measurement. received_s = captured_s = frame / rate."""
    time_s = sample.frame / rate_hz
    values = (
        sample.frame,
        time_s,
        sample.displacement_x_px,
        time_s,
        sample.features,
        sample.inliers,
        sample.displacement_y_px,
        sample.rotation_rad,
        sample.variance_x_px2,
        sample.variance_y_px2,
        sample.variance_rotation_rad2,
        sample.status,
    )
    return ",".join("" if isinstance(v, float) and isnan(v) else repr(v) for v in values)


def summary(samples: list[VisualSample], rate_hz: float) -> VideoSummary:
    """Frames, how many were measured, and how the scene moved: along x or y, whichever varies more."""
    good = [s.status == TrackingStatus.MEASURED for s in samples]
    x = np.array([s.displacement_x_px for s in samples], dtype=np.float64)
    y = np.array([s.displacement_y_px for s in samples], dtype=np.float64)
    if sum(good) < 2:
        return VideoSummary(len(samples), sum(good), "x", np.nan, np.nan, np.nan)
    axis, moved = ("x", x) if np.nanstd(x) >= np.nanstd(y) else ("y", y)
    return VideoSummary(
        len(samples),
        sum(good),
        axis,
        float(np.nanstd(moved)),
        float(np.nanmax(moved) - np.nanmin(moved)),
        main_frequency_hz(moved, rate_hz),
    )


def main_frequency_hz(moved: NDArray[np.float64], rate_hz: float) -> float:
    """The largest line of the spectrum, Hz; NaN where frames are few.

    Hann window, zeros to eight times the length, and a parabola through the logarithms of the highest three bins
    (Jacobsen and Kootsookos 2007). Frames without a measurement are bridged by straight lines.
    """
    there = np.isfinite(moved)
    if there.sum() < _MIN_SPECTRUM:
        return float("nan")
    index = np.arange(len(moved))
    filled = np.interp(index, index[there], moved[there])
    rest = filled - np.polyval(np.polyfit(index, filled, 1), index)
    length = 8 * len(rest)
    power = np.abs(np.fft.rfft(rest * np.hanning(len(rest)), length)) ** 2
    first = 8 * 2  # below two periods in the whole video: drift
    top = first + int(np.argmax(power[first:-1]))
    if power[top] <= 0.0:
        return float("nan")
    a, b, c = np.log(np.maximum(power[top - 1 : top + 2], 1e-300))
    bend = a - 2.0 * b + c
    shift = 0.5 * (a - c) / bend if bend < 0.0 else 0.0
    return float((top + shift) * rate_hz / length)
