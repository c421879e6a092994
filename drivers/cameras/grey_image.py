"""Converts any OpenCV image to uint8 grey."""

from typing import Any

import cv2
import numpy as np

from stillarm.drivers.cameras.camera import GreyImage


def grey_image(image: Any) -> GreyImage | None:
    """Grey values, (height, width), uint8, of a grey, BGR or BGRA image of 8 or 16 bit; else None."""
    if not isinstance(image, np.ndarray) or image.size == 0 or image.ndim not in (2, 3):
        return None
    if image.dtype == np.uint16:
        image = (image.astype(np.uint32) * 255 // 65535).astype(np.uint8)
    if image.dtype != np.uint8:
        return None
    if image.ndim == 2:
        return np.asarray(image, dtype=np.uint8)
    channels = image.shape[2]
    if channels == 1:
        return np.asarray(image[:, :, 0], dtype=np.uint8)
    if channels not in (3, 4):
        return None
    code = cv2.COLOR_BGR2GRAY if channels == 3 else cv2.COLOR_BGRA2GRAY
    return np.asarray(cv2.cvtColor(image, code), dtype=np.uint8)
