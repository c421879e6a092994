"""Bytes in, samples out, for every serial accelerometer: a table says what its frames look like.

Where a frame does not hold, the search goes on one byte behind its beginning and not behind its end, so that garbage
that looks like the beginning of a frame costs no good frame inside it. What comes out does not depend on how the bytes
are cut.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import nan
from typing import NamedTuple


class SerialSample(NamedTuple):
    """Acceleration, m/s^2, along the sensor's axes; the device's counter, status (-1: none) and time, s (NaN: none)."""

    x_m_s2: float
    y_m_s2: float
    z_m_s2: float
    counter: int = -1
    status: int = -1
    time_s: float = nan


@dataclass(frozen=True)
class Description:
    """What some devices tell of themselves: samples a second, the largest acceleration, the filter's group delay."""

    rate_hz: float
    range_m_s2: float
    delay_s: float


@dataclass(frozen=True)
class Framing:
    """What frames look like.

    length: of the frame that begins at a place of the buffer; 0: none does; None: more bytes are needed to tell.
    longest: of all frames, which bounds what garbage can hold up. valid: whether a frame's checksum holds.
    sample: what a valid frame carries; None where it is of another kind. describe: what a valid frame tells of the
    device, for kinds of device that do.
    """

    sync: bytes
    longest: int
    length: Callable[[bytearray, int], int | None]
    valid: Callable[[bytes], bool]
    sample: Callable[[bytes], SerialSample | None]
    describe: Callable[[bytes], Description | None] | None = None


class FrameDecoder:
    """Finds frames in a stream. frames: valid ones so far; rejected: beginnings of frames that did not hold.

    description: the last that the device gave.
    """

    def __init__(self, framing: Framing) -> None:
        """Begins with nothing."""
        self._framing = framing
        self._buffer = bytearray()
        self.frames = 0
        self.rejected = 0
        self.description: Description | None = None

    def feed(self, data: bytes) -> list[SerialSample]:
        """The samples that these bytes complete, oldest first."""
        framing, buffer = self._framing, self._buffer
        buffer += data
        samples = []
        at = 0
        while True:
            at = self._next_sync(at)
            length = framing.length(buffer, at) if at < len(buffer) else None
            if length is None or at + length > len(buffer):
                break
            frame = bytes(buffer[at : at + length])
            if not length or not framing.valid(frame):
                self.rejected += 1
                at += 1
                continue
            self.frames += 1
            at += length
            sample = framing.sample(frame)
            if sample is not None:
                samples.append(sample)
            elif framing.describe is not None:
                self.description = framing.describe(frame) or self.description
        del buffer[:at]
        return samples

    def clear(self) -> None:
        """Forget what has come, as after the port was opened anew."""
        self._buffer.clear()

    def _next_sync(self, at: int) -> int:
        """Where the next frame may begin: at a whole sync word, or at what may become one at the end."""
        buffer, sync = self._buffer, self._framing.sync
        found = buffer.find(sync, at)
        if found >= 0:
            return found
        for kept in range(min(len(sync) - 1, len(buffer) - at), 0, -1):
            if buffer.endswith(sync[:kept]):
                return len(buffer) - kept
        return len(buffer)
