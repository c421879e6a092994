"""The interface of every camera: live, file or simulated."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

GreyImage = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Frame:
    """One image as the camera delivered it.

    image: grey values, shape (height, width), uint8; only valid until the next call of read()
    counter: the camera's own frame counter, counting exposures; None if it has none
    stamp_s: the driver's own time of mid-exposure on the camera's clock; None if it has none
    exposure_s: exposure time; None if unknown
    """

    image: GreyImage
    counter: int | None
    stamp_s: float | None
    exposure_s: float | None


class Camera(Protocol):
    """A source of frames. Constructing opens nothing; start() does, and raises UserError with a remedy.

    notes: after start(), a line for each setting that the camera refused, with what to do.
    """

    notes: list[str]

    def start(self) -> None:
        """Open the device and begin to stream."""

    def read(self, timeout_s: float) -> Frame | None:
        """The next frame in order of arrival; None if none arrived in time. Raises EndOfStream at a file's end."""

    def close(self) -> None:
        """Stop streaming and release the device; may be called twice."""


class EndOfStream(Exception):
    """A file has no more frames."""
