"""One supervisor cycle as values: a frame and the controller's timestamp in, a visual sample out.

The same step runs live, in virtual time and in replay.
"""

from math import nan

import numpy as np
from numpy.typing import NDArray

from stillarm.common.datagrams.visual_sample import TrackingStatus, VisualSample
from stillarm.common.files.configuration import Tracker
from stillarm.drivers.cameras.camera import Frame
from stillarm.supervisor.tracking.tracker import FeatureTracker


class Supervisor:
    """Turns frames into visual samples. Pure: uses no clock, camera or socket."""

    def __init__(self, config: Tracker) -> None:
        """config: section [supervisor.tracker] of the configuration."""
        self._tracker = FeatureTracker(config)
        self._arrived = 0

    def step(self, frame: Frame, started_cycle: int) -> VisualSample:
        """Track one frame. started_cycle: n_i, the controller's timestamp when this cycle began; -1 if none
        yet.

        The sample's frame is the camera's counter, or the count of arrivals from 0 if the camera has no counter.
        """
        counter = self._arrived if frame.counter is None else frame.counter
        self._arrived += 1
        moved = self._tracker.track(frame.image)
        stamp = nan if frame.stamp_s is None else float(frame.stamp_s)
        exposure = nan if frame.exposure_s is None else float(frame.exposure_s)
        if moved.status != TrackingStatus.MEASURED:
            return VisualSample(
                frame=counter,
                started_cycle=started_cycle,
                status=int(moved.status),
                captured_s=stamp,
                exposure_s=exposure,
                features=moved.features,
                inliers=moved.inliers,
            )
        covariance = moved.covariance
        return VisualSample(
            frame=counter,
            started_cycle=started_cycle,
            status=int(moved.status),
            displacement_x_px=moved.dx,
            displacement_y_px=moved.dy,
            rotation_rad=moved.rotation,
            variance_x_px2=float(covariance[0, 0]),
            variance_y_px2=float(covariance[1, 1]),
            covariance_xy_px2=float(covariance[0, 1]),
            variance_rotation_rad2=float(covariance[2, 2]),
            captured_s=stamp,
            exposure_s=exposure,
            features=moved.features,
            inliers=moved.inliers,
        )

    def seen_points(self) -> NDArray[np.float32]:
        """Where the tracked features lie in the last measured image: (n, 2), x and y, px."""
        return self._tracker.seen_points()

    def restart(self) -> None:
        """Take the next good image as the new origin of the displacement."""
        self._tracker.restart()
