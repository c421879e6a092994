"""Finds the scene of the key frames in an image: near the expected place, or anywhere.

The cost of one image is bounded to about one frame period. There is one quick measurement where the scene is
expected. If that fails, there is one thorough attempt, either there or where the coarse search finds the scene. If the
scene is not found, the search continues in the next image, alternately at both places and with another reference of
the coarse search. Each attempt starts with a few features and uses all of them only once those agree.
"""

from dataclasses import replace
from math import hypot, inf

from stillarm.common.datagrams.visual_sample import TrackingStatus
from stillarm.common.files.configuration import Tracker
from stillarm.supervisor.tracking.coarse_search import CoarseView, coarse_shift, coarse_view, overlap_score
from stillarm.supervisor.tracking.key_frame import KeyFrame, KeyFrames
from stillarm.supervisor.tracking.matching.prepared_image import PreparedImage
from stillarm.supervisor.tracking.measurement import (
    UNSTEADY_LEVELS,
    Measurement,
    measure,
    measure_warily,
    nothing_found,
)
from stillarm.supervisor.tracking.pose import Pose, extrapolated, pose_since, total_pose

COASTING_FRAMES = 3  # number of lost frames for which constant velocity is still a fair guess
SAME_SCENE = 0.35  # score of coarse_search above which two small images are assumed to show the same scene
SURE = 0.5  # share of the features in view; if fewer agree, the small images must match as well
SMEARED = 0.5  # of the first sharpness: such an image may be reduced, and a failure is due to blur
STEADY_PX = 1.5  # prediction error of the last frame up to which the finest pyramid level is enough
BRIDGED_PX = 8.0  # prediction error up to which the quick measurement that failed would have succeeded
SHRINKS = (2, 4)  # reductions tried in turn if the image itself is too smeared
_ORIGIN = Pose(0.0, 0.0, 0.0)
_LAST = -1  # stands for the last measured image among the serial numbers of key frames


class SceneLocator:
    """Remembers the last poses and the references already tried. Deterministic."""

    def __init__(self, config: Tracker, keys: KeyFrames) -> None:
        """config: section [supervisor.tracker] of the configuration.

        keys: the key frames; the first one must be in it before the first call of locate().
        """
        self._config = config
        self._keys = keys
        self._last: PreparedImage | None = None
        self._last_pose = _ORIGIN
        self._before_pose = _ORIGIN
        self._surprise_px = inf  # error of the last prediction
        self._views: dict[int, CoarseView] = {}
        self._turn = 0
        self.reference_sharpness = 0.0  # of the scene in focus and at rest; 0 before it is known
        self.shrunk = False  # whether the last image had to be reduced
        self.lost = 0  # frames since the last measurement

    @property
    def last_pose(self) -> Pose:
        """Pose of the last measured image."""
        return self._last_pose

    def remember(self, current: PreparedImage, pose: Pose) -> None:
        """Remember an image that was measured."""
        self._before_pose = self._last_pose if self.lost == 0 and self._last is not None else pose
        self._last_pose = pose
        self._last = current
        self._views.clear()
        self.lost = self._turn = 0

    def is_smeared(self, image: PreparedImage) -> bool:
        """Whether an image is much less sharp than the first one."""
        return image.sharpness < SMEARED * self.reference_sharpness

    def locate(self, current: PreparedImage, key: KeyFrame) -> Measurement:
        """The pose of the scene in an image, preferably relative to `key`; or the reason why there is none."""
        frames = self.lost + 1
        coasting = frames <= COASTING_FRAMES
        predicted = extrapolated(self._before_pose, self._last_pose, frames) if coasting else self._last_pose
        if self._keys.leaves(key, predicted):
            key = self._keys.most_in_view(predicted)
        best = self._correlation(key.image, key.pose, current, predicted)
        failed_near = None
        if frames == 1 and not self.shrunk and best >= SAME_SCENE:
            found = self._quick(current, key, predicted)
            if found.status == TrackingStatus.MEASURED:
                return self._with_surprise(found, predicted)
            failed_near = predicted
        smeared = self.is_smeared(current) or self.is_smeared(key.image)
        found = nothing_found(key, predicted)
        if self.lost % 2 == 0 and (best >= SAME_SCENE or (coasting and smeared)):
            found = self._thorough(current, key, predicted, failed_near)
            if found.status == TrackingStatus.MEASURED:
                return self._with_surprise(found, predicted)
        else:
            guess, score = self._guess(current)
            best = max(best, score)
            if score >= SAME_SCENE:
                found = self._thorough(current, self._keys.most_in_view(guess), guess, failed_near)
                if found.status == TrackingStatus.MEASURED:
                    self._surprise_px = inf
                    return found
        self.shrunk = False
        if self.is_smeared(current):
            return replace(found, status=TrackingStatus.BLURRED)
        return replace(found, status=TrackingStatus.JUMPED) if best < SAME_SCENE else found

    def _with_surprise(self, found: Measurement, predicted: Pose) -> Measurement:
        self._surprise_px = _distance(found.pose, predicted)
        return found

    def _quick(self, current: PreparedImage, key: KeyFrame, predicted: Pose) -> Measurement:
        levels = 0 if self._surprise_px < STEADY_PX else UNSTEADY_LEVELS
        found = measure(key, current, predicted, self._config, min(levels, self._config.levels))
        return self._confirmed(current, found)

    def _thorough(
        self, current: PreparedImage, key: KeyFrame, pose: Pose, failed_near: Pose | None
    ) -> Measurement:
        """Measure near a pose that may be wrong: first with a few features on all levels, then with all of them."""
        if self.shrunk or self.is_smeared(current) or self.is_smeared(key.image):
            return self._in_small_images(current, key, pose, failed_near)
        return self._confirmed(current, measure_warily(key, current, pose, self._config, self._config.levels))

    def _in_small_images(
        self, current: PreparedImage, key: KeyFrame, pose: Pose, failed_near: Pose | None
    ) -> Measurement:
        config = self._config
        for shrink in SHRINKS:
            small = measure(key, current, pose, config, config.levels, shrink, few=True)
            if small.status == TrackingStatus.MEASURED and self._looks_alike(key, current, small.pose):
                break
        else:
            return replace(small, status=TrackingStatus.BLURRED)
        if failed_near is None or _distance(failed_near, small.pose) > BRIDGED_PX:
            full = measure_warily(key, current, small.pose, config, UNSTEADY_LEVELS)
            self.shrunk = full.status != TrackingStatus.MEASURED
            if not self.shrunk:
                return full
        self.shrunk = True
        found = measure(key, current, small.pose, config, 0, shrink)
        return found if found.status == TrackingStatus.MEASURED else small

    def _confirmed(self, current: PreparedImage, found: Measurement) -> Measurement:
        """If only a part of the features agrees, the images must match as well: in another scene, a quarter of the
        features may find a wrong match near their old place and agree by chance."""
        sure = found.inliers >= SURE * found.features
        if (
            found.status != TrackingStatus.MEASURED
            or sure
            or self._looks_alike(found.key, current, found.pose)
        ):
            return found
        return replace(found, status=TrackingStatus.INCONSISTENT)

    def _looks_alike(self, key: KeyFrame, current: PreparedImage, pose: Pose) -> bool:
        """Whether the small image matches the key frame's, or that of the last image, which is equally smeared."""
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
        """A coarse pose and its score, relative to the last measured image or a key frame, one of them per image."""
        references = [(f.serial, f.image, f.pose) for f in self._keys.frames]
        if self._last is not None:
            references.insert(0, (_LAST, self._last, self._last_pose))
        serial, image, pose = references[self._turn % len(references)]
        self._turn += 1
        if serial not in self._views:
            self._views[serial] = coarse_view(image.coarse)
        shift = coarse_shift(self._views[serial], coarse_view(current.coarse))
        since = Pose(shift.x * current.reduction, shift.y * current.reduction, 0.0)
        return total_pose(pose, since), shift.score


def _distance(a: Pose, b: Pose) -> float:
    return hypot(a.x - b.x, a.y - b.y)
