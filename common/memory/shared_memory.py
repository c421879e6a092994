"""Memory shared between processes by name: a plain block, and a byte ring.

The blocks are files in /dev/shm (elsewhere the directory for temporary files), mapped. They outlive a killed process,
so that its readers can finish. The process that made them removes them.

The sequence lock is the usual one: odd while writing; the reader takes the sequence, the data and the
sequence again. Words that one side writes while the other reads go through `words` or word_at(): storing an
item of a memoryview of format "Q" is one store of an aligned 8-byte word. struct.pack_into is not: it zeroes
the bytes first, and a reader sees the zero.
"""

import mmap
import os
import struct
import sys
import tempfile
import time
from pathlib import Path

from stillarm.common.user_error import UserError, reason_of

_MAGIC = 0x6D72616C6C697473  # "stillarm"
_HEADER = 64  # magic, size, two indices or a sequence, each on its own 8 bytes


def block_path(name: str) -> Path:
    """The file behind a block's name; names are plain words."""
    if not name or any(
        c not in "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-." for c in name
    ):
        raise UserError(f"shared memory name {name!r}: use letters, digits, '_', '-' and '.' only")
    shm = Path("/dev/shm")
    return (shm if shm.is_dir() else Path(tempfile.gettempdir())) / f"stillarm-{name}"


def _no_memory(name: str, path: Path, length: int, error: OSError) -> UserError:
    return UserError(
        f"shared memory {name!r}: cannot make {length} bytes at {path} "
        f"({reason_of(error)}); "
        f"free memory in {path.parent}, or remove the file if it is another user's"
    )


class SharedBlock:
    """A named block of `size` bytes, zeroed when made. `buffer` is a memoryview of the payload."""

    def __init__(self, name: str, size: int = 0, *, create: bool, wait_s: float = 0.0) -> None:
        """Make a block of `size` bytes, or open one that exists, waiting up to `wait_s` for it to appear.

        Raises UserError when there is none to open.
        """
        self.path = block_path(name)
        self._owner = create
        if create:
            descriptor = self._make(name, _HEADER + size)
        else:
            descriptor = self._open_existing(name, wait_s)
            size = os.fstat(descriptor).st_size - _HEADER
        try:
            self._inode = os.fstat(descriptor).st_ino
            self._map = mmap.mmap(descriptor, _HEADER + size)
        finally:
            os.close(descriptor)
        self.size = size
        self.header = memoryview(self._map)[:_HEADER]
        self.buffer = memoryview(self._map)[_HEADER:]
        self.words = self.header.cast("Q")
        if create:
            self.words[0] = _MAGIC  # last, so that a waiting reader finds it complete

    def _make(self, name: str, length: int) -> int:
        try:
            self.path.unlink(missing_ok=True)
            descriptor = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600)
        except OSError as error:
            raise _no_memory(name, self.path, length, error) from None
        try:
            # Not ftruncate: pages without memory behind them would kill their first writer (SIGBUS) when the memory
            # runs out, and would be fetched in the middle of a cycle.
            os.posix_fallocate(descriptor, 0, length)
        except OSError as error:
            os.close(descriptor)
            self.path.unlink(missing_ok=True)
            raise _no_memory(name, self.path, length, error) from None
        return descriptor

    def _open_existing(self, name: str, wait_s: float) -> int:
        deadline = time.monotonic() + wait_s
        while True:
            try:
                descriptor = os.open(self.path, os.O_RDWR)
            except FileNotFoundError:
                pass
            else:
                if os.fstat(descriptor).st_size > _HEADER and os.pread(descriptor, 8, 0) == _MAGIC.to_bytes(
                    8, sys.byteorder
                ):
                    return descriptor
                os.close(descriptor)
            if time.monotonic() >= deadline:
                raise UserError(
                    f"shared memory {name!r}: not there; start the process that provides it first"
                )
            time.sleep(0.005)

    def replaced(self) -> bool:
        """Whether the block was removed or made anew since it was opened: its provider restarted."""
        try:
            return self.path.stat().st_ino != self._inode
        except FileNotFoundError:
            return True

    def close(self) -> None:
        """Unmap, and remove the name when this side made it; may be called twice."""
        if self._map.closed:
            return
        self.words.release()
        self.header.release()
        self.buffer.release()
        self._map.close()
        # a successor's block of the same name is not this one's to remove
        if self._owner and not self.replaced():
            self.path.unlink(missing_ok=True)


def word_at(buffer: memoryview, offset: int) -> memoryview:
    """The 8-byte word at an offset (a multiple of 8) of a buffer, as item 0 of a view: read and stored whole."""
    return buffer[offset : offset + 8].cast("Q")


class SharedRing:
    """A ring of whole messages from one writer to one reader. The writer never waits: a full ring loses the
    message.

    Layout: the header holds the write index at 8, the read index at 16, the count of lost messages at 24, all
    counting up; each message is a 4-byte length and its bytes; a length of 2^32 - 1 means: go on at the
    start.
    """

    _LENGTH = struct.Struct("<I")
    _WRAP = 0xFFFFFFFF

    def __init__(self, name: str, size: int = 0, *, create: bool) -> None:
        """Make a ring of `size` bytes or open one that exists."""
        self.block = SharedBlock(name, size, create=create)
        self.lost = 0

    def put(self, message: bytes | bytearray | memoryview) -> bool:
        """Append a message; False (and counted) when there is no room."""
        words, buffer, size = self.block.words, self.block.buffer, self.block.size
        need = 4 + len(message)
        write = words[1]
        place = write % size
        to_end = size - place
        skip = to_end if to_end < need else 0
        if write + skip + need - words[2] > size:
            self.lost += 1
            words[3] = self.lost
            return False
        if skip:
            if to_end >= 4:
                self._LENGTH.pack_into(buffer, place, self._WRAP)
            write += skip
            place = 0
        self._LENGTH.pack_into(buffer, place, need - 4)
        buffer[place + 4 : place + need] = message
        words[1] = write + need
        return True

    def get(self) -> bytes | None:
        """Take the oldest message; None when the ring is empty."""
        words, buffer, size = self.block.words, self.block.buffer, self.block.size
        read = words[2]
        if read == words[1]:
            return None
        place = read % size
        length = self._LENGTH.unpack_from(buffer, place)[0] if size - place >= 4 else self._WRAP
        if length == self._WRAP:
            read += size - place
            place = 0
            length = self._LENGTH.unpack_from(buffer, 0)[0]
        message = bytes(buffer[place + 4 : place + 4 + length])
        words[2] = read + 4 + length
        return message

    @property
    def lost_by_writer(self) -> int:
        """How many messages the writer could not place."""
        return int(self.block.words[3])

    def close(self) -> None:
        """Release the memory."""
        self.block.close()
