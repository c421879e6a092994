"""The recorder: a process of its own that empties a daemon's ring into a recording.

It ends when it is asked to (SIGTERM, SIGINT) or when the daemon is gone, however that came; in either case it
first writes what the ring still holds and completes the file. Start it with RecorderClient.start().
"""

import contextlib
import os
import sys
import time
from collections.abc import Callable

import msgspec

from common.recording.header import RecordingHeader
from common.recording.recorder_client import RecorderClient
from common.recording.topics import TOPICS
from common.recording.writer import RecordingWriter
from common.shared_memory import SharedRing
from common.stop_signal import StopSignal
from common.user_error import UserError

__all__ = ["Drain", "RecorderClient", "main"]

_PERIOD_S = 0.03
_FLUSH_S = 0.5  # what a killed recorder may lose
_DECODERS = [(topic.name, msgspec.msgpack.Decoder(topic.message)) for topic in TOPICS]


class Drain:
    """Empties a ring into a writer. When writing fails it goes on emptying, so that the daemon counts no loss
    of its own.
    """

    def __init__(self, ring: SharedRing, writer: RecordingWriter, say: Callable[[str], None]) -> None:
        """`say` takes a line for the user."""
        self._ring = ring
        self._writer = writer
        self._say = say
        self._malformed = 0
        self.failed = False

    def drain(self) -> None:
        """Take what the ring holds now; what is put meanwhile may stay for the next time."""
        left = self._ring.block.size  # a daemon that never pauses must not keep this from ending
        while left > 0 and (message := self._ring.get()) is not None:
            left -= len(message) + 4
            if not self.failed:
                self._write(message)

    def _write(self, message: bytes) -> None:
        try:
            name, decoder = _DECODERS[message[0]]
            decoded = decoder.decode(memoryview(message)[1:])
        except (IndexError, msgspec.DecodeError, UnicodeDecodeError):
            self._malformed += 1
            if self._malformed == 1:
                self._say("a message in the ring does not fit its topic and is left out")
            return
        self._guarded(lambda: self._writer.write(name, decoded))

    def flush(self) -> None:
        """Hand everything to the operating system."""
        if not self.failed:
            self._guarded(self._writer.flush)

    def finish(self) -> None:
        """Take what is left and complete the file."""
        self.drain()
        if self.failed:
            with contextlib.suppress(UserError):  # said when it happened
                self._writer.close()
        else:
            self._guarded(self._writer.close)

    def _guarded(self, act: Callable[[], None]) -> None:
        try:
            act()
        except UserError as error:
            self.failed = True
            self._say(str(error))


def _say(line: str) -> None:
    with contextlib.suppress(OSError):  # the terminal may be gone with the daemon
        print(f"stillarm recorder: {line}", file=sys.stderr, flush=True)


def main(path: str, ring_name: str, daemon: int) -> int:
    """Run until the daemon asks or is gone. Returns 0 when the whole recording is on disk."""
    stop = StopSignal()
    try:
        header = msgspec.msgpack.decode(sys.stdin.buffer.read(), type=RecordingHeader)
        ring = SharedRing(ring_name, create=False)
        writer = RecordingWriter(path, header)
    except (UserError, msgspec.DecodeError) as error:
        print(error, flush=True)
        return 1
    drain = Drain(ring, writer, _say)
    print("ready", flush=True)
    sys.stdout.close()
    flushed = time.monotonic()
    # The parent of a process changes at the instant its parent is gone, and can never be a later process with
    # the same number: surer than to look the number up.
    while not stop and os.getppid() == daemon:
        drain.drain()
        if time.monotonic() - flushed >= _FLUSH_S:
            drain.flush()
            flushed = time.monotonic()
        time.sleep(_PERIOD_S)
    drain.finish()
    ring.block.path.unlink(missing_ok=True)
    ring.close()
    return int(drain.failed)


if __name__ == "__main__":
    path, ring_name, daemon = sys.argv[1:]
    status = main(path, ring_name, int(daemon))
    sys.stderr.flush()
    os._exit(status)  # sys.stdout is closed: nothing is left to flush
