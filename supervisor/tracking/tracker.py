"""The tracker: grey images in, the displacement of the static scene out (docs/tracking.md).

The tracker never guesses. An image in which no key frame's scene is found is flagged, with NaN. After a gap the search
continues in every image, among all key frames, and a result has the same origin as before. Images of a new scene are
JUMPED for as long as it stays: the images do not show how far the camera moved across a cut, and a controller would
mistake a guess for a measurement. restart() sets a new origin. There is one exception: a first frame that no second
one confirms does not become the origin (some cameras deliver a half-exposed or a test image first). It is replaced
after UNCONFIRMED_FRAMES.
"""

import numpy as np
from msgspec.structs import replace

from stillarm.common.datagrams.visual_sample import TrackingStatus
from stillarm.common.files.configuration import Tracker
from stillarm.supervisor.tracking.displacement import Displacement, Matrix
from stillarm.supervisor.tracking.image_quality import image_quality, is_frozen
from stillarm.supervisor.tracking.key_frame import KeyFrame, KeyFrames, take_key_frame
from stillarm.supervisor.tracking.locate import SceneLocator
from stillarm.supervisor.tracking.matching.features import Points
from stillarm.supervisor.tracking.matching.prepared_image import GreyImage, PreparedImage, is_image, prepared
from stillarm.supervisor.tracking.measurement import UNSTEADY_LEVELS, Measurement, measure_warily
from stillarm.supervisor.tracking.pose import Pose

UNCONFIRMED_FRAMES = 5
WINDOWS = (1.0, 0.7, 0.5, 0.33)  # of the configured one, tried in turn on the first image
SMALLEST_WINDOW_PX = 5
SMALL_IMAGE = 6.0  # windows high or wide: a larger image loses hardly a feature to the margin
AMPLE = 1.5  # times min_inliers: number of features required at the start
POOR_AGREEMENT = 0.35  # of the features in view: below this for POOR_FRAMES, new features are needed
POOR_FRAMES = 5
STRETCHED = 0.3  # of the allowed scatter: beyond it, perspective or scale are changing
UNSURE_PX2 = 2 * 0.03**2  # variance of a key frame's pose above which a correction pays
RETRY_FRAMES = 10  # wait before a key frame that could not be used is tried again
_ORIGIN = Pose(0.0, 0.0, 0.0)


class FeatureTracker:
    """Tracks features against key frames. Deterministic: the same images give the same numbers."""

    def __init__(self, config: Tracker) -> None:
        """config: section [supervisor.tracker] of the configuration."""
        self._configured = config
        self.restart()

    def restart(self) -> None:
        """Forget everything. The next good image becomes the origin."""
        self._previous: GreyImage | None = None
        self._shape: tuple[int, ...] | None = None
        self._forget_scene()

    def _forget_scene(self) -> None:
        self._use_windows(self._configured.window_px)
        self._key: KeyFrame | None = None
        self._serial = 0
        self._measured = 0
        self._poor = 0
        self._wait = 0

    def _use_windows(self, window_px: int) -> None:
        self._config = replace(self._configured, window_px=window_px)
        self._margin = window_px // 2
        self._keys = KeyFrames(self._margin)
        self._locator = SceneLocator(self._config, self._keys)

    @property
    def key_frames(self) -> int:
        """Number of key frames."""
        return len(self._keys.frames)

    def seen_points(self) -> Points:
        """Where the key frame's features lie in the last measured image, by its pose: (n, 2), x and y, px."""
        if self._key is None:
            return np.empty((0, 2), np.float32)
        return self._key.predicted_points(self._locator.last_pose)

    def track(self, image: GreyImage | None) -> Displacement:  # noqa: PLR0911 each fault leaves at once
        """Measure one image: grey, uint8, shape (height, width), the same shape every time. Never raises."""
        if image is None or not is_image(image) or (self._shape is not None and image.shape != self._shape):
            return self._none(TrackingStatus.NO_IMAGE)
        if is_frozen(image, self._previous):
            return self._none(TrackingStatus.FROZEN)
        current = prepared(image, self._config.blur_sigma_px)
        self._previous = image.copy() if self._config.blur_sigma_px > 0.0 else current.grey
        quality = image_quality(current, self._locator.reference_sharpness)
        if quality != TrackingStatus.MEASURED:
            return self._none(quality)
        if self._key is None:
            return self._begin(current)
        found = self._locator.locate(current, self._key)
        if found.status != TrackingStatus.MEASURED:
            if self._measured == 1 and self._locator.lost + 1 >= UNCONFIRMED_FRAMES:
                self._forget_scene()
                return self._begin(current)
            return self._none(found.status, found.features, found.inliers)
        found = self._hand_over(current, found)
        self._remember(current, found.pose)
        x, y, rotation = found.pose
        return Displacement(found.status, x, y, rotation, found.covariance, found.features, found.inliers)

    def _none(self, status: TrackingStatus, features: int = 0, inliers: int = 0) -> Displacement:
        self._locator.lost += 1
        return Displacement(status, features=features, inliers=inliers)

    def _begin(self, current: PreparedImage) -> Displacement:
        key = self._first_key(current)
        count = len(key.points)
        if count < self._config.min_inliers:
            return self._none(TrackingStatus.FEW_FEATURES, features=count)
        self._shape = current.grey.shape
        self._locator.reference_sharpness = current.sharpness
        self._take_up(key)
        self._remember(current, _ORIGIN)
        return Displacement(TrackingStatus.MEASURED, 0.0, 0.0, 0.0, np.zeros((3, 3)), count, count)

    def _first_key(self, current: PreparedImage) -> KeyFrame:
        """Features of the first image. A small image uses smaller windows, which leave more of it for features."""
        keys = []
        small = min(current.grey.shape) < SMALL_IMAGE * self._configured.window_px
        for share in WINDOWS if small else WINDOWS[:1]:
            self._use_windows(max(SMALLEST_WINDOW_PX, int(share * self._configured.window_px)) | 1)
            keys.append((self._config.window_px, self._new_key(current, _ORIGIN, np.zeros((3, 3)))))
            if len(keys[-1][1].points) >= AMPLE * self._config.min_inliers:
                return keys[-1][1]
        enough = (k for k in keys if len(k[1].points) >= self._config.min_inliers)
        window, key = next(enough, keys[0])  # the largest window with enough features
        self._use_windows(window)
        return key

    def _remember(self, current: PreparedImage, pose: Pose) -> None:
        self._locator.remember(current, pose)
        self._measured += 1

    def _hand_over(self, current: PreparedImage, found: Measurement) -> Measurement:
        """Choose the key frame for the next images. The measurement changes if an older key frame, or one of smaller
        variance, takes over."""
        self._poor = self._poor + 1 if found.inliers < POOR_AGREEMENT * found.features else 0
        self._wait = max(0, self._wait - 1)
        self._key = found.key
        leaving = self._keys.leaves(found.key, found.pose)
        if self._poor >= POOR_FRAMES or leaving:
            candidate = self._keys.best_other(found.key, found.pose) if self._wait == 0 else None
            again = self._tried(candidate, current, found)
            if again is not None:
                return again
            self._poor = 0
            self._take_up(self._new_key(current, found.pose, found.covariance))
        elif found.stretch > STRETCHED and not (self._locator.shrunk or self._locator.is_smeared(current)):
            self._take_up(self._new_key(current, found.pose, found.covariance))
        elif self._locator.is_smeared(found.key.image) and not self._locator.is_smeared(current):
            self._take_up(self._new_key(current, found.pose, found.covariance))
            self._locator.shrunk, self._wait = False, 0
        elif self._wait == 0:
            again = self._tried(self._keys.surer(found.key, found.pose), current, found)
            return again or self._mended(current, found)
        return found

    def _mended(self, current: PreparedImage, found: Measurement) -> Measurement:
        """Correct a pose that was handed over in smeared images, as soon as a key frame of smaller variance is partly
        in view."""
        if self._locator.shrunk or self._wait > 0 or found.key.variance < UNSURE_PX2:
            return found
        key = self._keys.anchor(found.key, found.pose)
        if key is None:
            return found
        again = measure_warily(key, current, found.pose, self._config, UNSTEADY_LEVELS)
        self._wait = RETRY_FRAMES
        if again.status != TrackingStatus.MEASURED or _variance(again.covariance) > 0.1 * _variance(
            found.covariance
        ):
            return found
        self._take_up(self._new_key(current, again.pose, again.covariance))
        return again

    def _tried(self, key: KeyFrame | None, current: PreparedImage, found: Measurement) -> Measurement | None:
        if key is None:
            return None
        again = measure_warily(key, current, found.pose, self._config, UNSTEADY_LEVELS)
        agree = again.inliers >= POOR_AGREEMENT * again.features and again.stretch <= STRETCHED
        if again.status != TrackingStatus.MEASURED or not agree:
            self._wait = RETRY_FRAMES
            return None
        self._key, self._poor = key, 0
        return again

    def _new_key(self, current: PreparedImage, pose: Pose, covariance: Matrix) -> KeyFrame:
        config, smeared = self._config, self._locator.is_smeared(current)
        return take_key_frame(
            current, pose, covariance, self._serial, config.features, config.window_px, smeared
        )

    def _take_up(self, key: KeyFrame) -> None:
        if len(key.points) < self._config.min_inliers:
            return
        self._serial += 1
        self._keys.add(key)
        self._key = key


def _variance(covariance: Matrix) -> float:
    return float(covariance[0, 0] + covariance[1, 1])


def warm_up(config: Tracker, width_px: int, height_px: int) -> None:
    """Track images of noise. The first call of each OpenCV function takes 15 to 22 ms, too long for a cycle."""
    noise = np.random.default_rng(0).integers(0, 256, (height_px, width_px), dtype=np.uint8)
    tracker = FeatureTracker(config)
    for shift in (0, 1, 2):
        tracker.track(np.roll(noise, shift, axis=1))
    tracker.track(noise[::-1])
