"""Displacement from images: our tracker and its peers on the same images; for `stillarm benchmark vision`.

The scene is a random texture whose spectrum falls with frequency, as in natural scenes. It is blurred like a lens, and
shifted exactly by its Fourier phase, also beyond the image's borders: 640x480, 3 px amplitude at 2.6 Hz, 65 frames a
second, sensor noise of 2 grey levels. error_px_rms is the error of x and y together against the truth.
"""

import time
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.configuration import Tracker
from stillarm.supervisor.tracking.tracker import FeatureTracker, warm_up

Image = NDArray[np.uint8]
Method = Callable[[Image], tuple[float, float]]

WIDTH_PX, HEIGHT_PX = 640, 480
FRAMES = 50
RATE_HZ = 65.0
NOISE_GREY_LEVELS = 2.0
FLICKER = 0.08
OCCLUDER = (160, 320)  # a sixth of the image


def run(trials: int, seed: int) -> dict[str, Any]:
    """The table of the contract: rows of method, error_px_rms, ms_per_frame. An unmeasured frame
    makes the error NaN.
    """
    cv2.setNumThreads(1)
    warm_up(Tracker(), WIDTH_PX, HEIGHT_PX)
    squares: dict[str, list[float]] = {}
    seconds: dict[str, list[float]] = {}
    for trial in range(trials):
        for case in ("", ", flicker 8 %", ", occluder over a sixth"):
            truth, images = _recording(np.random.default_rng((seed, trial)), case)
            methods = _methods()
            for image, true in zip(images, truth, strict=True):
                for name, method in methods.items():
                    began = time.perf_counter()
                    x, y = method(image)
                    row = name + case
                    seconds.setdefault(row, []).append(time.perf_counter() - began)
                    squares.setdefault(row, []).append(0.5 * ((x - true[0]) ** 2 + (y - true[1]) ** 2))
    return {
        "rows": [
            {
                "method": name,
                "error_px_rms": float(np.sqrt(np.mean(squares[name]))),
                "ms_per_frame": 1e3 * float(np.median(seconds[name])),
            }
            for name in squares
        ]
    }


def _recording(random: np.random.Generator, case: str) -> tuple[NDArray[np.float64], list[Image]]:
    # larger than the image, so that what leaves does not wrap around
    height, width = (HEIGHT_PX + 96, WIDTH_PX + 128)
    fy, fx = np.fft.fftfreq(height)[:, None], np.fft.rfftfreq(width)[None, :]
    f2 = fx**2 + fy**2
    spectrum = (
        np.fft.rfft2(random.normal(size=(height, width))) * np.exp(-f2 / 0.22**2) / np.sqrt(f2 + 0.01**2)
    )
    spectrum[0, 0] = 0.0
    spectrum *= 40.0 / np.fft.irfft2(spectrum, (height, width)).std()
    t = np.arange(FRAMES) / RATE_HZ
    truth = np.stack([3.0 * np.sin(2.0 * np.pi * 2.6 * t), 0.5 * np.sin(2.0 * np.pi * 1.3 * t)], axis=1)
    patch = cv2.GaussianBlur(random.uniform(-700.0, 956.0, OCCLUDER), (0, 0), 2.0)
    images = []
    for i, (dx, dy) in enumerate(truth):
        shifted = spectrum * np.exp(-2j * np.pi * (fx * dx + fy * dy))
        grey = 128.0 + np.fft.irfft2(shifted, (height, width))[48 : 48 + HEIGHT_PX, 64 : 64 + WIDTH_PX]
        if "occluder" in case:
            left = (40 + 4 * i) % (WIDTH_PX - OCCLUDER[1])
            grey[150 : 150 + OCCLUDER[0], left : left + OCCLUDER[1]] = patch
        if "flicker" in case:
            grey *= 1.0 + FLICKER * np.sin(0.7 * i)
        grey += random.normal(0.0, NOISE_GREY_LEVELS, grey.shape)
        images.append(np.clip(np.rint(grey), 0, 255).astype(np.uint8))
    return truth, images


def _methods() -> dict[str, Method]:
    return {
        "stillarm": _ours(),
        "Lucas-Kanade, plain mean, frame to frame": _mean_flow(to_key_frame=False),
        "Lucas-Kanade, plain mean, key frame": _mean_flow(to_key_frame=True),
        "phase correlation, Hann": _phase_correlation(),
        "ECC translation": _ecc(),
    }


def _ours() -> Method:
    tracker = FeatureTracker(Tracker())

    def measure(image: Image) -> tuple[float, float]:
        found = tracker.track(image)
        return found.dx, found.dy

    return measure


def _mean_flow(to_key_frame: bool) -> Method:
    before: Image | None = None
    points: Any = None
    total = np.zeros(2)

    def measure(image: Image) -> tuple[float, float]:
        nonlocal before, points, total
        if before is None:
            points = cv2.goodFeaturesToTrack(image, 100, 0.01, 30)
            before = image
            return 0.0, 0.0
        moved, found, _ = cv2.calcOpticalFlowPyrLK(before, image, points, None)  # type: ignore[call-overload]
        good = found.ravel() == 1
        shift = (moved - points).reshape(-1, 2)[good].mean(axis=0)
        if to_key_frame:
            return float(shift[0]), float(shift[1])
        total = total + shift
        before, points = image, moved[good]
        return float(total[0]), float(total[1])

    return measure


def _phase_correlation() -> Method:
    before: Any = None
    window = cv2.createHanningWindow((WIDTH_PX, HEIGHT_PX), cv2.CV_32F)

    def measure(image: Image) -> tuple[float, float]:
        nonlocal before
        now = image.astype(np.float32)
        if before is None:
            before = now
        (x, y), _ = cv2.phaseCorrelate(before, now, window)
        return x, y

    return measure


def _ecc() -> Method:
    before: Image | None = None
    warp = np.eye(2, 3, dtype=np.float32)
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 30, 1e-4)

    def measure(image: Image) -> tuple[float, float]:
        nonlocal before, warp
        if before is None:
            before = image
        _, warp = cv2.findTransformECC(before, image, warp, cv2.MOTION_TRANSLATION, criteria)  # type: ignore[assignment]
        return float(warp[0, 2]), float(warp[1, 2])

    return measure
