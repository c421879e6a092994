"""Decodes the bytes of every serial accelerometer into samples; a table describes its frames.

After an invalid frame, the search continues one byte behind its beginning, not behind its end. Garbage that looks like
the beginning of a frame therefore costs no valid frame inside it. The result does not depend on how the bytes are
split.
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
    """A device's description of itself: sample rate, largest acceleration, group delay of the filter."""

    rate_hz: float
    range_m_s2: float
    delay_s: float


@dataclass(frozen=True)
class Framing:
    """Description of a device's frames.

    length: of the frame that begins at an offset of the buffer; 0: no frame; None: more bytes are needed.
    longest: of all frames, which bounds the delay by garbage. valid: whether a frame's checksum is right.
    sample: of a valid frame; None for another kind of frame. describe: description of the device in a valid frame, for
    devices that send one.
    """

    sync: bytes
    longest: int
    length: Callable[[bytearray, int], int | None]
    valid: Callable[[bytes], bool]
    sample: Callable[[bytes], SerialSample | None]
    describe: Callable[[bytes], Description | None] | None = None


class FrameDecoder:
    """Finds frames in a stream. frames: number of valid frames; rejected: number of false starts.

    description: the device's last description.
    """

    def __init__(self, framing: Framing) -> None:
        """Start with an empty buffer."""
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
        """Discard the buffer, as after the port was reopened."""
        self._buffer.clear()

    def _next_sync(self, at: int) -> int:
        """Offset of the next possible frame: at a whole sync word, or at a partial one at the end."""
        buffer, sync = self._buffer, self._framing.sync
        found = buffer.find(sync, at)
        if found >= 0:
            return found
        for kept in range(min(len(sync) - 1, len(buffer) - at), 0, -1):
            if buffer.endswith(sync[:kept]):
                return len(buffer) - kept
        return len(buffer)
