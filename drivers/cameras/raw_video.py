"""Raw high-speed video of Photron cameras: a text header (.cih) and bare frames (.mraw), as their manual defines.

The .cih has a line "Key : value" for each key. Color Bit is the size of a pixel in the file: 8, 12 (two pixels in three
bytes, the first pixel's high bits first) or 16 (little-endian). EffectiveBit Depth and EffectiveBit Side say which of
these bits contain the value: Lower, the value itself; Higher, the value shifted up to the top. Only mono is read.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stillarm.common.user_error import UserError, reason_of
from stillarm.drivers.cameras.camera import GreyImage

_PIXEL_BITS = (8, 12, 16)


@dataclass(frozen=True, slots=True)
class RawVideo:
    """Header of a raw video.

    width, height: px; frames: number of frames; pixel_bits: bits per pixel in the file; value_bits: significant bits,
    from bit 0; rate_hz: frames a second, 0 if not stated.
    """

    width: int
    height: int
    frames: int
    pixel_bits: int
    value_bits: int
    rate_hz: float

    @property
    def frame_bytes(self) -> int:
        """Bytes of a frame in the .mraw."""
        return self.width * self.height * self.pixel_bits // 8


def read_header(path: Path) -> RawVideo:
    """Read a .cih. Raises UserError with file and key."""
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise UserError(f"{path}: cannot be read ({reason_of(error)}); the .mraw needs its .cih") from None
    pairs = (line.split(" : ", 1) for line in text.splitlines() if " : " in line)
    values = {key.strip(): value.strip() for key, value in pairs}

    def positive(key: str) -> int:
        word = values.get(key, "")
        if not word.isascii() or not word.isdigit() or int(word) == 0:
            raise UserError(f"{path}: {key} = {word!r}: must be a positive integer; export the video again")
        return int(word)

    pixel_bits = positive("Color Bit")
    if pixel_bits not in _PIXEL_BITS or values.get("Color Type", "Mono") != "Mono":
        raise UserError(
            f"{path}: Color Bit = {pixel_bits}, Color Type = {values.get('Color Type', 'Mono')}: "
            "only mono with 8, 12 or 16 bit is supported; export as such, or as a video"
        )
    depth = positive("EffectiveBit Depth") if "EffectiveBit Depth" in values else pixel_bits
    lower = values.get("EffectiveBit Side", "Lower") == "Lower"
    try:
        rate_hz = float(values.get("Record Rate(fps)", "0"))
    except ValueError:
        rate_hz = 0.0
    return RawVideo(
        width=positive("Image Width"),
        height=positive("Image Height"),
        frames=positive("Total Frame"),
        pixel_bits=pixel_bits,
        value_bits=min(depth, pixel_bits) if lower else pixel_bits,
        rate_hz=rate_hz,
    )


def raw_video_frames(header_path: Path) -> Iterator[GreyImage]:
    """The frames of a .cih with its .mraw in the same folder, uint8. Raises UserError if a file is absent or cut."""
    video = read_header(header_path)
    path = header_path.with_suffix(".mraw")
    if not path.exists():
        raise UserError(f"{path}: missing; the .cih needs its .mraw in the same folder")
    held = path.stat().st_size // video.frame_bytes if video.frame_bytes else 0
    if held < video.frames:
        raise UserError(
            f"{path}: contains {held} of the {video.frames} frames that the .cih states; copy it again"
        )
    with path.open("rb") as file:
        for _ in range(video.frames):
            yield _image(np.frombuffer(file.read(video.frame_bytes), np.uint8), video)


def _image(data: NDArray[np.uint8], video: RawVideo) -> GreyImage:
    shape = video.height, video.width
    if video.pixel_bits == 8:
        values: NDArray[np.uint16] = data.astype(np.uint16)
    elif video.pixel_bits == 16:
        values = data.view("<u2").astype(np.uint16)
    else:
        triple = data.reshape(-1, 3).astype(np.uint16)
        values = np.stack(
            ((triple[:, 0] << 4) | (triple[:, 1] >> 4), ((triple[:, 1] & 15) << 8) | triple[:, 2]), axis=1
        ).ravel()
    excess = video.value_bits - 8
    grey = values >> excess if excess >= 0 else values << -excess
    return np.asarray(np.minimum(grey, 255), dtype=np.uint8).reshape(shape)
