"""Whether an image can hold a measurement at all, before any feature is looked for."""

import numpy as np

from common.visual_sample import TrackingStatus
from supervisor.tracking.prepared_image import GreyImage, PreparedImage

DARK_MEAN = 12.0  # grey levels: below this, with little contrast, a lens cap or a lamp that is off
DARK_CONTRAST = 6.0
BLANK_CONTRAST = 2.5  # grey levels, after averaging over squares: sensor noise alone stays below
SATURATED_LEVEL = 250.0
SATURATED_FRACTION = 0.9  # a drawing on white paper is a scene; what is left of one beyond this is not
BLURRED_SHARPNESS = 0.05  # of the sharpness of the first key frame


def is_frozen(image: GreyImage, previous: GreyImage | None) -> bool:
    """Whether an image is the previous one to the bit: no real sensor gives that twice, a stuck buffer
    does."""
    if previous is None or image.shape != previous.shape:
        return False
    middle = image.shape[0] // 2  # tells nearly always, in a hundredth of the time
    return np.array_equal(image[middle], previous[middle]) and np.array_equal(image, previous)


def image_quality(image: PreparedImage, reference_sharpness: float) -> TrackingStatus:
    """MEASURED when nothing speaks against the image; else DARK, SATURATED, BLANK or BLURRED.

    reference_sharpness: that of the scene when in focus and at rest; 0 before there is one.
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
