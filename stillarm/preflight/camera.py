"""Checks the camera: rate, stamps, exposure, light, features; from its images, or from a running supervisor's data."""

import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from math import isfinite, nan

import numpy as np

from stillarm.common.datagrams.visual_sample import TrackingStatus, VisualSample
from stillarm.common.files.configuration import CameraDevice, Tracker
from stillarm.common.files.model import Model
from stillarm.drivers.cameras.camera import Camera, EndOfStream
from stillarm.preflight.verdict import Verdict, fail, ok, warn

_FEWEST_FRAMES = 5
_RATE_OFF = 0.05  # relative error of the frame rate
_DARK, _BRIGHT = 20.0, 235.0  # mean grey levels
_MEASURED_SHARE = 0.9  # of the images that must be tracked
_WANDER = 3.0  # times the model's noise: beyond it the image is out of focus, or the rig rings
_LONGER = 1.02  # an exposure that exceeds the period by this factor is refused
_CAUSES = {
    TrackingStatus.DARK: "the image is dark: take the cap off, add light, or lengthen camera.exposure_s",
    TrackingStatus.SATURATED: "the image is overexposed: shorten camera.exposure_s, or lower camera.gain",
    TrackingStatus.BLANK: "the image has no texture: focus the lens, or put something with edges into view",
    TrackingStatus.BLURRED: "the image is blurred: focus the lens, shorten camera.exposure_s",
    TrackingStatus.FROZEN: "the camera repeats the same image: restart it, check its cable",
    TrackingStatus.FEW_FEATURES: "too few features: focus the lens, put something with edges into view, or add light",
    TrackingStatus.JUMPED: "the scene is not found again from one image to the next: does the rig or the scene move?",
    TrackingStatus.INCONSISTENT: "features do not move together: people or machines move in view? point it elsewhere",
    TrackingStatus.NO_IMAGE: "no image: check the camera's cable and power",
}


@dataclass(frozen=True)
class CameraFacts:
    """What was observed of the camera.

    arrived_s: arrival of each frame, on this clock. samples: the tracker's results. grey: mean grey level; NaN if the
    images were not available here. counted: whether the camera counts its exposures. notes: settings that it refused.
    """

    arrived_s: tuple[float, ...]
    samples: tuple[VisualSample, ...]
    grey: float
    counted: bool
    notes: tuple[str, ...] = ()


def watch_camera(
    camera: Camera,
    tracker: Tracker,
    span_s: float,
    *,
    clock: Callable[[], float] = time.monotonic,
) -> CameraFacts:
    """Take frames of a started camera for a while, and track them."""
    from stillarm.supervisor.step import Supervisor  # not above: OpenCV is not on every controller's computer

    supervisor = Supervisor(tracker)
    arrived, samples, grey, counted = [], [], [], True
    begun = clock()
    while clock() < begun + span_s:
        try:
            frame = camera.read(min(0.1, span_s))
        except EndOfStream:
            break
        if frame is None:
            continue
        arrived.append(clock())
        counted = counted and frame.counter is not None
        grey.append(float(np.mean(frame.image[::4, ::4])))
        samples.append(supervisor.step(frame, -1))
    return CameraFacts(
        tuple(arrived), tuple(samples), float(np.median(grey)) if grey else nan, counted, tuple(camera.notes)
    )


def judge_camera(facts: CameraFacts, device: CameraDevice, model: Model) -> list[Verdict]:
    """Rate, counters and stamps, exposure, light, features."""
    verdicts = [warn("camera", note) for note in facts.notes]
    if len(facts.arrived_s) < _FEWEST_FRAMES:
        return [
            *verdicts,
            fail(
                "camera",
                f"camera.device = {device.device!r}: {len(facts.arrived_s)} frames arrived; check cable, power and "
                "trigger (camera.trigger), and that nothing else uses it",
            ),
        ]
    if device.driver == "file":
        verdicts.append(warn("camera", "frames from a file have no rate, no stamps, no delay"))
    else:
        verdicts += [_judge_rate(facts, model), _judge_counters(facts), _judge_exposure(facts, device, model)]
        verdicts.append(_judge_stamps(facts))
    return [*verdicts, *_judge_images(facts, model)]


def _period_s(facts: CameraFacts) -> float:
    """Period of the exposures, by the camera's counter if it has one, so that lost frames do not lengthen it."""
    arrived = facts.arrived_s
    steps = len(arrived) - 1
    if facts.counted:
        steps = max(1, facts.samples[-1].frame - facts.samples[0].frame)
    return (arrived[-1] - arrived[0]) / steps


def _judge_rate(facts: CameraFacts, model: Model) -> Verdict:
    rate, expected = 1.0 / max(_period_s(facts), 1e-9), model.camera.frame_rate_hz
    text = f"{rate:.1f} frames a second (the model says {expected:g})"
    if model.camera.mode == "triggered":
        return ok("camera", f"{text}, triggered")
    if abs(rate / expected - 1.0) > _RATE_OFF:
        return fail(
            "camera",
            f"{text}: shorten camera.exposure_s, take a smaller image or a faster port, set "
            "camera.frame_rate_hz; or enter the measured rate as the model's camera.frame_rate_hz",
        )
    return ok("camera", text)


def _judge_counters(facts: CameraFacts) -> Verdict:
    if not facts.counted:
        return warn(
            "camera", "it does not count its exposures: lost frames cannot be distinguished from late ones"
        )
    counts = [sample.frame for sample in facts.samples]
    lost = counts[-1] - counts[0] + 1 - len(counts)
    if any(after <= before for before, after in pairwise(counts)):
        return fail(
            "camera", "its frame counter runs backwards or stands still; update its firmware or driver"
        )
    if lost > 0.1 * len(counts):
        return warn(
            "camera",
            f"{lost} of {lost + len(counts)} frames lost: this computer is too busy, or the cable is bad",
        )
    return ok("camera", f"frame counter without fault, {lost} lost")


def _judge_stamps(facts: CameraFacts) -> Verdict:
    stamps = np.array([sample.captured_s for sample in facts.samples])
    there = np.isfinite(stamps)
    if not there.any():
        return ok("camera", "it gives no time stamps; the delay is estimated without")
    if not there.all() or np.any(np.diff(stamps) <= 0.0):
        return warn(
            "camera",
            f"{int(np.sum(there))} of {len(stamps)} frames have a valid stamp; see camera.stamp_reference",
        )
    period = float(np.median(np.diff(stamps)))
    jitter = float(np.std(np.diff(stamps)))
    return ok("camera", f"time stamps, {1e3 * period:.2f} ms apart, within {1e3 * jitter:.2f} ms")


def _judge_exposure(facts: CameraFacts, device: CameraDevice, model: Model) -> Verdict:
    told = [sample.exposure_s for sample in facts.samples if isfinite(sample.exposure_s)]
    exposure = told[-1] if told else device.exposure_s
    period = min(_period_s(facts), 1.0 / (device.frame_rate_hz or model.camera.frame_rate_hz))
    if not exposure:
        return warn(
            "camera",
            f"it does not report its exposure; the model's {1e3 * model.camera.exposure_s:g} ms is used",
        )
    if max(exposure, device.exposure_s) > _LONGER * period:
        return fail(
            "camera",
            f"camera.exposure_s: {1e3 * max(exposure, device.exposure_s):.1f} ms is longer than the period of "
            f"{1e3 * period:.1f} ms; shorten it and add light, or lower the rate",
        )
    if abs(exposure - model.camera.exposure_s) > 0.1 * exposure:
        return warn(
            "camera",
            f"exposure {1e3 * exposure:.1f} ms instead of the model's {1e3 * model.camera.exposure_s:g} ms; enter "
            "it as the model's camera.exposure_s",
        )
    return ok("camera", f"exposure {1e3 * exposure:.1f} ms")


def _judge_images(facts: CameraFacts, model: Model) -> list[Verdict]:
    measured = [sample for sample in facts.samples if sample.measured]
    share = len(measured) / len(facts.samples)
    if share < _MEASURED_SHARE:
        status, _ = Counter(sample.status for sample in facts.samples if not sample.measured).most_common(1)[
            0
        ]
        cause = _CAUSES.get(TrackingStatus(status), "the tracker gives no measurement")
        if facts.grey < _DARK:
            cause = _CAUSES[TrackingStatus.DARK]
        elif facts.grey > _BRIGHT:
            cause = _CAUSES[TrackingStatus.SATURATED]
        return [fail("camera", f"{100.0 * share:.0f} % of the images could be tracked: {cause}")]
    if facts.grey < _DARK or facts.grey > _BRIGHT:
        word = "dark: add light" if facts.grey < _DARK else "bright: shorten camera.exposure_s"
        return [warn("camera", f"mean grey level {facts.grey:.0f} of 255: {word}")]
    features = int(np.median([sample.features for sample in measured]))
    inliers = int(np.median([sample.inliers for sample in measured]))
    wander = float(np.std([sample.displacement_x_px for sample in measured]))
    if wander > _WANDER * model.camera.noise_std_px:
        return [
            fail(
                "camera",
                f"the image wanders by {wander:.2f} px (the model says {model.camera.noise_std_px:g}): is the rig at "
                "rest? otherwise focus the lens, add light, or put something with edges into view",
            )
        ]
    return [ok("camera", f"{features} features, {inliers} agree; at rest within {wander:.3f} px")]
