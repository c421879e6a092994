"""An image as the tracker uses it: a copy, a small version for the coarse search, and a measure of sharpness."""

from dataclasses import dataclass
from math import hypot

import cv2
import numpy as np
from numpy.typing import NDArray

SmallImage = NDArray[np.float32]
GreyImage = NDArray[np.uint8]

MIN_SIDE_PX = 32
_SAMPLES = 10000  # of sharpness, in whole rows, which are read fastest
_COARSE_SIDE_PX = 120  # small enough to cost little, large enough to find a shift to a few px


@dataclass(frozen=True, slots=True)
class PreparedImage:
    """grey: the image, blurred if configured, shape (height, width), uint8; owned.

    half: averaged over squares of 2 px, uint8
    coarse: the image averaged over squares of `reduction` px, float32
    mean, contrast: mean and standard deviation of the coarse image, grey levels
    sharpness: larger eigenvalue of the mean structure tensor over the mean grey value squared, 1/px^2. It is computed
        from differences over 2 px minus those over 1 px: white noise is in both and cancels. It is the larger
        eigenvalue because motion blur leaves the gradients across the motion, while defocus leaves none.
    """

    grey: GreyImage
    half: GreyImage
    coarse: SmallImage
    reduction: int
    mean: float
    contrast: float
    sharpness: float


def is_image(image: object) -> bool:
    """Whether the tracker accepts this image: uint8, two-dimensional, at least 32 px high and wide."""
    return (
        isinstance(image, np.ndarray)
        and image.dtype == np.uint8
        and image.ndim == 2
        and min(image.shape) >= MIN_SIDE_PX
    )


def prepared(image: GreyImage, blur_sigma_px: float) -> PreparedImage:
    """Copy an image, blurred by a Gaussian if blur_sigma_px > 0, and compute its small version and statistics."""
    blurred = cv2.GaussianBlur(image, (0, 0), blur_sigma_px) if blur_sigma_px > 0.0 else image.copy()
    grey = np.asarray(blurred, dtype=np.uint8)
    reduction = max(1, round(min(grey.shape) / _COARSE_SIDE_PX))
    half = reduced(grey, 2)
    small = reduced(grey, reduction) if reduction % 2 else reduced(half, reduction // 2)
    coarse = small.astype(np.float32)
    mean, deviation = cv2.meanStdDev(coarse)
    contrast = float(deviation[0, 0])
    return PreparedImage(
        grey=grey,
        half=half,
        coarse=coarse,
        reduction=reduction,
        mean=float(mean[0, 0]),
        contrast=contrast,
        sharpness=_sharpness(grey),
    )


def reduced(grey: GreyImage, factor: int) -> GreyImage:
    """The image averaged over squares of `factor` px; itself for 1. Its pixel x is at factor * (x + 0.5) - 0.5."""
    if factor == 1:
        return grey
    height, width = grey.shape[0] // factor, grey.shape[1] // factor
    whole = grey[: height * factor, : width * factor]
    return np.asarray(cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA), dtype=np.uint8)


def inner_product(a: SmallImage, b: SmallImage) -> float:
    """Sum of the products. numpy's dot would wake a second thread above 10 000 values, which took 10 ms on a busy
    machine."""
    return float(np.einsum("ij,ij->", a, b))


def _sharpness(grey: GreyImage) -> float:
    height, width = grey.shape[0] - 2, grey.shape[1] - 2  # so that all neighbours are inside
    step = max(1, height * width // _SAMPLES)
    here = grey[:height:step, :width].astype(np.float32)
    xx = yy = xy = 0.0
    for lag, sign in ((2, 1.0), (1, -1.0)):
        x = grey[:height:step, lag : width + lag] - here
        y = grey[lag : height + lag : step, :width] - here
        xx += sign * inner_product(x, x)
        yy += sign * inner_product(y, y)
        xy += sign * inner_product(x, y)
    largest = (0.5 * (xx + yy) + hypot(0.5 * (xx - yy), xy)) / here.size
    return max(0.0, largest) / max(1.0, float(here.mean())) ** 2
