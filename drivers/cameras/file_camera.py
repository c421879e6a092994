"""Frames from files: a video, a folder of images in natural order, or raw high-speed video (.cih with .mraw).

Files have no clock: a frame's counter is its index in the file, from 0. Frames are delivered as fast as they are
requested; a caller that needs the recorded rate must keep time. A video's stamp is its play time, not the time of its
exposure, and is left out.
"""

import re
from collections.abc import Iterator
from pathlib import Path

import cv2

from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera import EndOfStream, Frame, GreyImage
from stillarm.drivers.cameras.grey_image import grey_image
from stillarm.drivers.cameras.raw_video import raw_video_frames

_IMAGES = {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".ppm", ".webp"}
_RAW = {".cih", ".mraw"}


class FileCamera:
    """A camera that plays files; implements stillarm.drivers.cameras.camera.Camera."""

    def __init__(self, path: str | Path, named: str = "") -> None:
        """path: a video file, a folder of images, or a .cih or .mraw file. Opens nothing yet.

        named: how errors name it; empty: as the key of the configuration that holds it.
        """
        self._path = Path(path)
        self._named = named or f"camera.device = {str(self._path)!r}"
        self._images: Iterator[GreyImage] | None = None
        self._first: GreyImage | None = None
        self._count = 0
        self.notes: list[str] = []

    def start(self) -> None:
        """Open the file and read its first frame. Raises UserError if there is nothing to read."""
        self.close()
        if not self._path.exists():
            raise UserError(
                f"{self._named}: no such file or folder; give a video, a folder of images or a .cih"
            )
        if self._path.is_dir():
            self._images = _folder_frames(self._path)
        elif self._path.suffix.lower() in _RAW:
            self._images = raw_video_frames(self._path.with_suffix(".cih"))
        else:
            self._images = _video_frames(self._path)
        self._count = 0
        self._first = next(self._images, None)
        if self._first is None:
            raise UserError(
                f"{self._named}: contains no readable frame; give a video "
                "whose codec OpenCV knows (convert it: ffmpeg -i IN -c:v mjpeg OUT.avi), a folder of images, "
                "or a .cih with its .mraw"
            )

    def read(self, timeout_s: float) -> Frame | None:
        """The next frame, at once. Raises EndOfStream after the last."""
        image, self._first = self._first, None
        if image is None:
            image = next(self._images, None) if self._images is not None else None
        if image is None:
            raise EndOfStream(str(self._path))
        frame = Frame(image, self._count, None, None)
        self._count += 1
        return frame

    def close(self) -> None:
        """Close the file; may be called twice."""
        if self._images is not None:
            closing = getattr(self._images, "close", None)
            if closing is not None:
                closing()
        self._images = self._first = None


def natural_order(name: str) -> list[tuple[int, int, str]]:
    """A key that sorts frame2 before frame10."""
    parts = re.findall(r"[0-9]+|[^0-9]+", name.lower())
    return [(0, int(part), "") if part.isdigit() and part.isascii() else (1, 0, part) for part in parts]


def _folder_frames(folder: Path) -> Iterator[GreyImage]:
    paths = sorted(
        (p for p in folder.iterdir() if p.suffix.lower() in _IMAGES), key=lambda p: natural_order(p.name)
    )
    for path in paths:
        image = grey_image(cv2.imread(str(path), cv2.IMREAD_UNCHANGED))
        if image is None:
            raise UserError(f"{path}: not an image that OpenCV can read; remove it or write it again")
        yield image


def _video_frames(path: Path) -> Iterator[GreyImage]:
    capture = cv2.VideoCapture(str(path))
    try:
        while True:
            good, image = capture.read()
            grey = grey_image(image) if good else None
            if grey is None:
                return
            yield grey
    finally:
        capture.release()
