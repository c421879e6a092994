"""Tests whether an image can give a measurement, before any feature is tracked."""

import numpy as np

from stillarm.common.datagrams.visual_sample import TrackingStatus
from stillarm.supervisor.tracking.matching.prepared_image import GreyImage, PreparedImage

DARK_MEAN = 12.0  # grey levels: below this, with little contrast, a lens cap is on or a lamp is off
DARK_CONTRAST = 6.0
BLANK_CONTRAST = 2.5  # grey levels, after averaging over squares: sensor noise alone stays below
SATURATED_LEVEL = 250.0
SATURATED_FRACTION = 0.9  # a drawing on white paper is a scene; an image above this fraction is not
BLURRED_SHARPNESS = 0.05  # of the sharpness of the first key frame


def is_frozen(image: GreyImage, previous: GreyImage | None) -> bool:
    """Whether an image equals the previous one bit by bit. A stuck buffer repeats an image; a real sensor does not."""
    if previous is None or image.shape != previous.shape:
        return False
    middle = image.shape[0] // 2  # one row decides nearly always, in a hundredth of the time
    return np.array_equal(image[middle], previous[middle]) and np.array_equal(image, previous)


def image_quality(image: PreparedImage, reference_sharpness: float) -> TrackingStatus:
    """MEASURED if the image passes all tests; otherwise DARK, SATURATED, BLANK or BLURRED.

    reference_sharpness: sharpness of the scene in focus and at rest; 0 before it is known.
    """
    if image.mean < DARK_MEAN and image.contrast < DARK_CONTRAST:
        return TrackingStatus.DARK
    if np.count_nonzero(image.coarse >= SATURATED_LEVEL) > SATURATED_FRACTION * image.coarse.size:
        return TrackingStatus.SATURATED
    if image.contrast < BLANK_CONTRAST:
        return TrackingStatus.BLANK
    if image.sharpness < BLURRED_SHARPNESS * reference_sharpness:
        return TrackingStatus.BLURRED
    return TrackingStatus.MEASURED
