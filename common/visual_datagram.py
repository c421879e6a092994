"""A visual sample as the body of a datagram, and back; with the times from which the two clocks are compared."""

from math import nan
from typing import Any, NamedTuple

from common.visual_sample import VisualSample

_FLOATS = 9
_STAMPS = 3


class LinkTimes(NamedTuple):
    """When the latest timestamp left the controller (on its clock), when it was read and when these data left
    (on the supervisor's), s; NaN where unknown.
    """

    sent_s: float = nan
    received_s: float = nan
    answered_s: float = nan


NO_TIMES = LinkTimes()


def visual_body(
    controller_session: int, sample: VisualSample, times: LinkTimes = NO_TIMES
) -> tuple[Any, ...]:
    """The body of a VISUAL datagram: session of the timestamps, frame, n_i, status, nine numbers,
    features, inliers, three times.
    """
    return (
        controller_session,
        sample.frame,
        sample.started_cycle,
        sample.status,
        sample.displacement_x_px,
        sample.displacement_y_px,
        sample.rotation_rad,
        sample.variance_x_px2,
        sample.variance_y_px2,
        sample.covariance_xy_px2,
        sample.variance_rotation_rad2,
        sample.captured_s,
        sample.exposure_s,
        sample.features,
        sample.inliers,
        *times,
    )


def read_visual_body(body: tuple[Any, ...]) -> tuple[int, VisualSample, LinkTimes] | None:
    """Session of the timestamps, the sample and the times; None when a value is of the wrong kind."""
    session, frame, started, status, *rest = body
    numbers, integers, times = rest[:_FLOATS], rest[_FLOATS:-_STAMPS], rest[-_STAMPS:]
    if not all(type(v) is int for v in (session, frame, started, status, *integers)):
        return None
    if not all(type(v) is float for v in (*numbers, *times)):
        return None
    return session, VisualSample(frame, started, status, *numbers, *integers), LinkTimes(*times)
