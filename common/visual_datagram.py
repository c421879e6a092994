"""A visual sample as the body of a datagram, and back."""

from typing import Any

from common.visual_sample import VisualSample

_FLOATS = 9


def visual_body(controller_session: int, sample: VisualSample) -> tuple[Any, ...]:
    """The body of a VISUAL datagram: session of the timestamps, frame, n_i, status, nine numbers,
    features, inliers.
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
    )


def read_visual_body(body: tuple[Any, ...]) -> tuple[int, VisualSample] | None:
    """Session of the timestamps and the sample; None when a value is of the wrong kind."""
    session, frame, started, status, *rest = body
    numbers, integers = rest[:_FLOATS], rest[_FLOATS:]
    if not all(type(v) is int for v in (session, frame, started, status, *integers)):
        return None
    if not all(type(v) is float for v in numbers):
        return None
    return session, VisualSample(frame, started, status, *numbers, *integers)
