"""Images from another process: a ring of image slots in shared memory, one writer, one reader.

Layout of the payload: width, height, number of slots (8 bytes each, padded to 64), then the slots. A slot is
64 bytes of sequence lock, frame index, frame counter (-1: none), stamp_s and exposure_s (NaN: none), then
the image row by row, padded to 64. In the block's header, the word at 8 counts the published frames, that at
16 the requested frames.

The writer never waits. If the reader falls behind by more frames than the ring has slots, the oldest are lost
(GenICam's OldestFirstOverwrite): for control, an old image is worth less than a new one.
"""

import struct
import time
from math import isnan, nan

import numpy as np
from numpy.typing import NDArray

from stillarm.common.memory.shared_memory import SharedBlock, word_at
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera import Frame, GreyImage

_SHAPE = struct.Struct("<3Q")
_SLOT = struct.Struct("<qqdd")  # after the sequence
_SLOT_HEAD = 64
_PUBLISHED, _REQUESTED = 1, 2  # words of the header


def _slot_bytes(width: int, height: int) -> int:
    return _SLOT_HEAD + -(-width * height // 64) * 64


class FrameRingWriter:
    """The camera's end of the ring. Always keeps the last `slots` frames for a reader."""

    def __init__(self, name: str, width: int, height: int, slots: int) -> None:
        """Make the ring `name`, replacing an existing one. Images have shape (height, width)."""
        held = slots + 1  # the slot that is being overwritten does not count
        self._block = SharedBlock(name, _SHAPE.size + 40 + held * _slot_bytes(width, height), create=True)
        self._images = _images(self._block.buffer, width, height, held)
        self._shape = (height, width)
        self._published = 0
        self._sequences = _sequences(self._block.buffer, width, height, held)
        shape = self._block.buffer[: _SHAPE.size].cast("Q")
        shape[0], shape[1] = width, height
        shape[2] = held  # written last, since readers wait for it
        shape.release()

    def publish(
        self, image: GreyImage, counter: int | None, stamp_s: float | None, exposure_s: float | None
    ) -> None:
        """Publish the next frame. image: shape (height, width), uint8; it is copied."""
        if image.shape != self._shape or image.dtype != np.uint8:
            raise ValueError(f"image of {image.shape} {image.dtype}: the ring takes {self._shape} uint8")
        slot = self._published % len(self._images)
        place = 64 + slot * _slot_bytes(self._shape[1], self._shape[0])
        buffer = self._block.buffer
        lock = self._sequences[slot]
        lock[0] += 1
        _SLOT.pack_into(
            buffer,
            place + 8,
            self._published,
            -1 if counter is None else counter,
            nan if stamp_s is None else stamp_s,
            nan if exposure_s is None else exposure_s,
        )
        self._images[slot][:] = image
        lock[0] += 1
        self._published += 1
        self._block.words[_PUBLISHED] = self._published

    def requested(self) -> int:
        """Number of frames that the reader has requested since the ring was made; freerun ignores it."""
        return int(self._block.words[_REQUESTED])

    def close(self) -> None:
        """Remove the ring; may be called twice."""
        self._images.clear()
        for lock in self._sequences:
            lock.release()
        self._sequences.clear()
        self._block.close()


class FrameRingReader:
    """The consumer's end of the ring: takes the frames in order, skipping those already overwritten."""

    def __init__(self, name: str, *, wait_s: float = 0.0, from_newest: bool = False) -> None:
        """Open the ring `name`, waiting up to `wait_s` for it. from_newest: skip the frames that are already there.

        Raises UserError if there is none.
        """
        deadline = time.monotonic() + wait_s
        self._block = SharedBlock(name, create=False, wait_s=wait_s)
        width, height, held = _SHAPE.unpack_from(self._block.buffer, 0)
        while not held:
            if time.monotonic() >= deadline:
                self._block.close()
                raise UserError(f"frame ring {name!r}: never completed; restart the process that provides it")
            time.sleep(0.001)
            width, height, held = _SHAPE.unpack_from(self._block.buffer, 0)
        self._images = _images(self._block.buffer, width, height, held)
        self._sequences = _sequences(self._block.buffer, width, height, held)
        self._slot_bytes = _slot_bytes(width, height)
        self._own = np.empty((height, width), dtype=np.uint8)
        self._next = self._published() if from_newest else 0
        self.lost = 0

    def take(self) -> Frame | None:
        """The next frame; None if there is none yet. Its image is a copy, valid until the next call.

        `lost` counts frames that were overwritten before or during the read.
        """
        buffer, slots = self._block.buffer, len(self._images)
        while self._next < (published := self._published()):
            oldest = published - slots + 1
            if self._next < oldest:
                self.lost += oldest - self._next
                self._next = oldest
            index, self._next = self._next, self._next + 1
            place = 64 + index % slots * self._slot_bytes
            lock = self._sequences[index % slots]
            sequence = lock[0]
            held, counter, stamp, exposure = _SLOT.unpack_from(buffer, place + 8)
            if sequence & 1 == 0 and held == index:
                np.copyto(self._own, self._images[index % slots])
                if lock[0] == sequence:
                    return Frame(
                        image=self._own,
                        counter=None if counter < 0 else counter,
                        stamp_s=None if isnan(stamp) else stamp,
                        exposure_s=None if isnan(exposure) else exposure,
                    )
            self.lost += 1
        return None

    @property
    def waiting(self) -> int:
        """Number of frames to take, including those already overwritten."""
        return self._published() - self._next

    def pass_over(self, frames: int) -> None:
        """Skip the next frames; they count as lost."""
        self._next += frames
        self.lost += frames

    def request(self, frames: int) -> None:
        """Request `frames` more exposures, for which a triggered camera waits."""
        self._block.words[_REQUESTED] += frames

    def replaced(self) -> bool:
        """Whether the ring was removed or replaced because the camera's process restarted."""
        return self._block.replaced()

    def close(self) -> None:
        """Release the memory; may be called twice."""
        self._images.clear()
        for lock in self._sequences:
            lock.release()
        self._sequences.clear()
        self._block.close()

    def _published(self) -> int:
        return int(self._block.words[_PUBLISHED])


def _images(buffer: memoryview, width: int, height: int, slots: int) -> list[NDArray[np.uint8]]:
    """The slots' images as arrays on the shared memory, shape (height, width) each."""
    images = []
    for slot in range(slots):
        place = 64 + slot * _slot_bytes(width, height) + _SLOT_HEAD
        flat = np.frombuffer(buffer, dtype=np.uint8, count=width * height, offset=place)
        images.append(flat.reshape(height, width))
    return images


def _sequences(buffer: memoryview, width: int, height: int, slots: int) -> list[memoryview]:
    """The slots' sequence locks."""
    return [word_at(buffer, 64 + slot * _slot_bytes(width, height)) for slot in range(slots)]
