"""The supervisor's reduced image with its tracked points, on its way to the page. Pure: a datagram in, a message out.

Datagram: VIEW_MARK, then u16 length of a JSON head, the head, a JPEG (supervisor/view.py makes it). The page gets the
same behind the kind VIEW_KIND.
"""

import struct

import msgspec

VIEW_MARK = b"SAVW"
VIEW_KIND = 255
_LENGTH = struct.Struct("<H")


class ViewHead(msgspec.Struct, frozen=True):
    """scale: pixels of the full image for one of this. points: x, y of each tracked feature, in this image's pixels."""

    frame: int
    width_px: int
    height_px: int
    scale: float
    points: list[tuple[float, float]]


_DECODER = msgspec.json.Decoder(ViewHead)


def view_message(datagram: bytes) -> bytes | None:
    """The page's binary message; None for a datagram that is no such view."""
    try:
        (length,) = _LENGTH.unpack_from(datagram, len(VIEW_MARK))
        begin = len(VIEW_MARK) + _LENGTH.size
        _DECODER.decode(datagram[begin : begin + length])
    except (struct.error, msgspec.DecodeError, msgspec.ValidationError):
        return None
    if datagram[begin + length : begin + length + 2] != b"\xff\xd8":  # what every JPEG begins with
        return None
    return bytes((VIEW_KIND, 0)) + datagram[len(VIEW_MARK) :]
