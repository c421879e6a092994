"""The tracker: one grey image after another in, the displacement of the static scene out. docs/tracking.md
explains.

It never invents a number: an image in which the scene of a key frame is not found is flagged, with NaN.
After a gap the search goes on in every image, among all key frames, and what is found is on the same origin
as before. A scene that
replaces the old one is JUMPED for as long as it stays: how far the camera moved across a cut cannot be known
from images, and a position that is carried on by guesswork would be taken for a measurement by a controller.
restart() sets a new origin when an operator wants one. The one exception: a first frame that no second one
ever confirmed is not an origin (cameras deliver a half-exposed or a test image first), and is replaced after
UNCONFIRMED_FRAMES.
"""

from dataclasses import replace
from math import hypot, inf

import numpy as np

from common.configuration import Tracker
from common.visual_sample import TrackingStatus
from supervisor.tracking.coarse_search import coarse_shift, overlap_score
from supervisor.tracking.displacement import Displacement, Matrix
from supervisor.tracking.image_quality import image_quality, is_frozen
from supervisor.tracking.key_frame import KeyFrame, KeyFrames, take_key_frame
from supervisor.tracking.measurement import Measurement, measure, nothing_found
from supervisor.tracking.pose import Pose, extrapolated, pose_since, total_pose
from supervisor.tracking.prepared_image import GreyImage, PreparedImage, is_image, prepared

UNCONFIRMED_FRAMES = 5
COASTING_FRAMES = 3  # for how many lost frames constant velocity is still a fair guess
SAME_SCENE = 0.35  # coarse_search's score, above which a coarse shift is worth trying
SMEARED = 0.5  # of the first sharpness: such an image may be shrunk; one that was lost was lost to blur
STEADY_PX = 1.5  # prediction error of the last frame, up to which the finest pyramid level alone is enough
UNSTEADY_LEVELS = 1  # bridges 10 px
POOR_AGREEMENT = 0.35  # of the features in view: below this for POOR_FRAMES, fresh features are wanted
POOR_FRAMES = 5
UNSURE_PX2 = 2 * 0.03**2  # variance of a key frame's pose that is worth mending
RETRY_FRAMES = 10  # before a key frame that could not be taken up is tried again
SHRINKS = (2, 4)  # tried in turn where the image itself is too smeared
_ORIGIN = Pose(0.0, 0.0, 0.0)


class FeatureTracker:
    """Tracks features against key frames. Deterministic: the same images give the same numbers."""

    def __init__(self, config: Tracker) -> None:
        """config: section [supervisor.tracker] of the configuration."""
        self._config = config
        self._margin = config.window_px // 2
        self.restart()

    def restart(self) -> None:
        """Forget everything: the next good image is the origin."""
        self._previous: GreyImage | None = None
        self._shape: tuple[int, ...] | None = None
        self._forget_scene()

    def _forget_scene(self) -> None:
        self._keys = KeyFrames(self._margin)
        self._key: KeyFrame | None = None
        self._serial = 0
        self._reference_sharpness = 0.0
        self._last: PreparedImage | None = None
        self._last_pose = _ORIGIN
        self._before_pose = _ORIGIN
        self._surprise_px = inf  # how far off the last prediction was
        self._smeared = False  # whether the last image had to be shrunk
        self._lost = 0  # frames since the last measurement
        self._measured = 0
        self._poor = 0
        self._wait = 0
        self._turn = 0

    @property
    def key_frames(self) -> int:
        """How many key frames are kept."""
        return len(self._keys.frames)

    def track(self, image: GreyImage | None) -> Displacement:  # noqa: PLR0911 each fault leaves at once
        """Measure one image: grey, uint8, shape (height, width), the same shape every time. Never raises."""
        if image is None or not is_image(image) or (self._shape is not None and image.shape != self._shape):
            return self._none(TrackingStatus.NO_IMAGE)
        if is_frozen(image, self._previous):
            return self._none(TrackingStatus.FROZEN)
        current = prepared(image, self._config.blur_sigma_px)
        self._previous = image.copy() if self._config.blur_sigma_px > 0.0 else current.grey
        quality = image_quality(current, self._reference_sharpness)
        if quality != TrackingStatus.MEASURED:
            return self._none(quality)
        if self._key is None:
            return self._begin(current)
        found = self._locate(current, self._key)
        if found.status != TrackingStatus.MEASURED:
            if self._measured == 1 and self._lost + 1 >= UNCONFIRMED_FRAMES:
                self._forget_scene()
                return self._begin(current)
            return self._none(found.status, found.features, found.inliers)
        found = self._hand_over(current, found)
        self._remember(current, found.pose)
        x, y, rotation = found.pose
        return Displacement(found.status, x, y, rotation, found.covariance, found.features, found.inliers)

    def _none(self, status: TrackingStatus, features: int = 0, inliers: int = 0) -> Displacement:
        self._lost += 1
        return Displacement(status, features=features, inliers=inliers)

    def _begin(self, current: PreparedImage) -> Displacement:
        key = self._new_key(current, _ORIGIN, np.zeros((3, 3)))
        count = len(key.points)
        if count < self._config.min_inliers:
            return self._none(TrackingStatus.FEW_FEATURES, features=count)
        self._shape = current.grey.shape
        self._reference_sharpness = current.sharpness
        self._take_up(key)
        self._remember(current, _ORIGIN)
        return Displacement(TrackingStatus.MEASURED, 0.0, 0.0, 0.0, np.zeros((3, 3)), count, count)

    def _remember(self, current: PreparedImage, pose: Pose) -> None:
        steady = self._lost == 0 and self._measured > 0
        self._before_pose = self._last_pose if steady else pose
        self._last_pose = pose
        self._last = current
        self._lost = self._turn = 0
        self._measured += 1

    def _locate(self, current: PreparedImage, key: KeyFrame) -> Measurement:
        frames = self._lost + 1
        coasting = frames <= COASTING_FRAMES
        predicted = extrapolated(self._before_pose, self._last_pose, frames) if coasting else self._last_pose
        if self._keys.leaves(key, predicted):
            key = self._keys.most_in_view(predicted)
        found = nothing_found(key, predicted)
        # features are dear to look for in every image of a scene that has gone
        if coasting or self._correlation(key.image, key.pose, current, predicted) >= SAME_SCENE:
            found = self._near(current, key, predicted, frames)
        if found.status == TrackingStatus.MEASURED:
            self._surprise_px = _distance(found.pose, predicted)
            return found
        best = self._correlation(key.image, key.pose, current, predicted)
        guess, score = self._guess(current)
        best = max(best, score)
        if score >= SAME_SCENE:
            again = self._near(current, self._keys.most_in_view(guess), guess, 0)
            if again.status == TrackingStatus.MEASURED:
                self._surprise_px = inf
                return again
        status = found.status
        if self._is_smeared(current):
            status = TrackingStatus.BLURRED
        elif best < SAME_SCENE:
            status = TrackingStatus.JUMPED
        return Measurement(status, key, predicted, found.covariance, found.features, found.inliers)

    def _near(self, current: PreparedImage, key: KeyFrame, predicted: Pose, frames: int) -> Measurement:
        """Measure near a predicted pose: quickly if the last prediction was good, thoroughly, then in small
        images."""
        config = self._config
        smeared = self._is_smeared(current) or self._is_smeared(key.image)
        first_levels = 0 if self._surprise_px < STEADY_PX else UNSTEADY_LEVELS
        if frames == 1 and config.levels > first_levels and not self._smeared:
            found = measure(key, current, predicted, config, first_levels)
            if found.status == TrackingStatus.MEASURED:
                return found
        if not self._smeared:
            found = measure(key, current, predicted, config, config.levels)
            if found.status == TrackingStatus.MEASURED or not smeared:
                return found
        for shrink in SHRINKS:
            small = measure(key, current, predicted, config, config.levels, shrink)
            if small.status == TrackingStatus.MEASURED and self._looks_alike(key, current, small.pose):
                found = measure(key, current, small.pose, config, UNSTEADY_LEVELS)
                self._smeared = found.status != TrackingStatus.MEASURED
                return small if self._smeared else found
        self._smeared = False
        return replace(small, status=TrackingStatus.BLURRED)

    def _is_smeared(self, current: PreparedImage) -> bool:
        return current.sharpness < SMEARED * self._reference_sharpness

    def _looks_alike(self, key: KeyFrame, current: PreparedImage, pose: Pose) -> bool:
        """Whether the small images agree: with the key frame's, or with the last one, smeared like
        this one.
        """
        if self._correlation(key.image, key.pose, current, pose) >= SAME_SCENE:
            return True
        last = self._last
        return last is not None and self._correlation(last, self._last_pose, current, pose) >= SAME_SCENE

    def _correlation(
        self, before: PreparedImage, before_pose: Pose, current: PreparedImage, pose: Pose
    ) -> float:
        since, reduction = pose_since(before_pose, pose), current.reduction
        shift = round(since.x / reduction), round(since.y / reduction)
        return overlap_score(before.coarse, current.coarse, *shift)

    def _guess(self, current: PreparedImage) -> tuple[Pose, float]:
        """A coarse pose and its score, against the last image measured or a key frame: one of them
        in each image.
        """
        references = [(f.image, f.pose) for f in self._keys.frames]
        if self._last is not None:
            references.insert(0, (self._last, self._last_pose))
        image, pose = references[self._turn % len(references)]
        self._turn += 1
        shift = coarse_shift(image.coarse, current.coarse)
        since = Pose(shift.x * current.reduction, shift.y * current.reduction, 0.0)
        return total_pose(pose, since), shift.score

    def _hand_over(self, current: PreparedImage, found: Measurement) -> Measurement:
        """Choose the key frame for the images to come; the measurement changes when an older or surer one
        counts."""
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
        elif self._is_smeared(found.key.image) and not self._is_smeared(current):
            self._take_up(self._new_key(current, found.pose, found.covariance))
            self._smeared, self._wait = False, 0
        elif self._wait == 0:
            again = self._tried(self._keys.surer(found.key, found.pose), current, found)
            return again or self._mended(current, found)
        return found

    def _mended(self, current: PreparedImage, found: Measurement) -> Measurement:
        """Mend a pose that was handed over in smeared images, as soon as a surer key frame is in view a
        little."""
        if self._smeared or self._wait > 0 or found.key.variance < UNSURE_PX2:
            return found
        key = self._keys.anchor(found.key, found.pose)
        if key is None:
            return found
        again = measure(key, current, found.pose, self._config, UNSTEADY_LEVELS)
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
        again = measure(key, current, found.pose, self._config, UNSTEADY_LEVELS)
        if again.status != TrackingStatus.MEASURED or again.inliers < POOR_AGREEMENT * again.features:
            self._wait = RETRY_FRAMES
            return None
        self._key, self._poor = key, 0
        return again

    def _new_key(self, current: PreparedImage, pose: Pose, covariance: Matrix) -> KeyFrame:
        return take_key_frame(
            current, pose, covariance, self._serial, self._config.features, self._margin + 1
        )

    def _take_up(self, key: KeyFrame) -> None:
        if len(key.points) < self._config.min_inliers:
            return
        self._serial += 1
        self._keys.add(key)
        self._key = key


def _variance(covariance: Matrix) -> float:
    return float(covariance[0, 0] + covariance[1, 1])


def _distance(a: Pose, b: Pose) -> float:
    return hypot(a.x - b.x, a.y - b.y)


def warm_up(config: Tracker, width_px: int, height_px: int) -> None:
    """Track images of noise: the first call of each OpenCV function takes 15 to 22 ms, which no cycle
    should."""
    noise = np.random.default_rng(0).integers(0, 256, (height_px, width_px), dtype=np.uint8)
    tracker = FeatureTracker(config)
    for shift in (0, 1, 2):
        tracker.track(np.roll(noise, shift, axis=1))
    tracker.track(noise[::-1])
