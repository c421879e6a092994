"""What the supervisor measures in one frame, as a value and as the message Visual with the times beside it."""

from enum import IntEnum
from math import nan
from typing import Any, NamedTuple

import msgspec

from stillarm.common.datagrams.messages import Visual

FARTHEST_PX = 1e6


class TrackingStatus(IntEnum):
    """Why a frame gave a measurement, or none. Only MEASURED carries numbers to be used."""

    MEASURED = 0
    NO_IMAGE = 1
    DARK = 2
    SATURATED = 3
    BLANK = 4  # no texture
    BLURRED = 5
    FROZEN = 6  # the same image again, to the bit
    JUMPED = 7  # the scene changed: nothing in it matches the key frame
    FEW_FEATURES = 8
    INCONSISTENT = 9  # features disagree about one rigid displacement


class VisualSample(msgspec.Struct, frozen=True, gc=False):
    """Displacement of the static scene in one frame, relative to the first frame, in image axes.

    displacement_x_px, displacement_y_px, rotation_rad: global displacement at the image centre (NaN unless
    MEASURED) variance_x_px2, variance_y_px2, covariance_xy_px2, variance_rotation_rad2: its covariance
    frame: counter of exposures if the camera has one, else of arrivals
    captured_s: the camera's own stamp, converted to mid-exposure as far as known, on its own clock; NaN if
    none
    started_cycle: n_i, the controller's timestamp when the supervisor cycle began; -1 before the first one
    restarted: the first of a supervisor that was started anew: from here on "the first frame" is another one
    """

    frame: int
    started_cycle: int
    status: int
    displacement_x_px: float = nan
    displacement_y_px: float = nan
    rotation_rad: float = nan
    variance_x_px2: float = nan
    variance_y_px2: float = nan
    covariance_xy_px2: float = nan
    variance_rotation_rad2: float = nan
    captured_s: float = nan
    exposure_s: float = nan
    features: int = 0
    inliers: int = 0
    restarted: bool = False

    @property
    def measured(self) -> bool:
        """Whether the displacement may be used: measured, and within what any scene can move."""
        return self.status == TrackingStatus.MEASURED and abs(self.displacement_x_px) < FARTHEST_PX


class LinkTimes(NamedTuple):
    """When the latest timestamp left the controller (on its clock), when it was read and when these data left
    (on the supervisor's), s; NaN where unknown.
    """

    sent_s: float = nan
    received_s: float = nan
    answered_s: float = nan


NO_TIMES = LinkTimes()


def visual_message(controller_session: int, sample: VisualSample, times: LinkTimes = NO_TIMES) -> Visual:
    """The message that answers the timestamps of a session; `restarted` stays behind: the receiver knows it."""
    fields: tuple[Any, ...] = (controller_session, *msgspec.structs.astuple(sample)[:-1], *times)
    return Visual(*fields)
