"""The recorder: a process of its own that empties a daemon's ring into a recording, sends telemetry, prints /log.

It ends on SIGTERM, on SIGINT, or when the daemon is gone for any reason. In each case it first writes the rest of the
ring and completes the file. Start it with RecorderClient.start().
"""

import contextlib
import gc
import os
import sys
import threading
import time
from collections.abc import Callable

import msgspec

from stillarm.common.files.configuration import Telemetry
from stillarm.common.memory.shared_memory import SharedRing
from stillarm.common.process.priority import raise_session_priority
from stillarm.common.process.service_notify import Watchdog, watchdog_period_s
from stillarm.common.process.stop_signal import StopSignal
from stillarm.common.recorder.panel_stream import PanelStream
from stillarm.common.recorder.recorder_client import LOADED, READY, RecorderClient, RecorderOrder
from stillarm.common.recorder.structured_log import log, log_line
from stillarm.common.recorder.telemetry import TelemetryBatches, telemetry_sender
from stillarm.common.recorder.warm_up import warm_up
from stillarm.common.recording.topics import TOPICS, LogLine
from stillarm.common.recording.writer import RecordingWriter
from stillarm.common.user_error import UserError

__all__ = ["Drain", "RecorderClient", "main"]

# what waits in the ring is lost when the ring is full; the daemon itself goes before all the same
_NICENESS = -10
_PERIOD_S = 0.01
_WATCH_S = 0.1
_FLUSH_S = 0.5  # what a killed recorder may lose
_DECODERS = [(topic.name, msgspec.msgpack.Decoder(topic.message)) for topic in TOPICS]


class Drain:
    """Empties a ring into a writer. When writing fails it continues to empty the ring, so that the daemon does not
    count losses.
    """

    def __init__(
        self,
        ring: SharedRing,
        writer: RecordingWriter | None,
        say: Callable[[str], None],
        show: Callable[[str, msgspec.Struct], None] = lambda topic_name, message: None,
    ) -> None:
        """`say` takes a line for the user; `show` each message, recorded or not."""
        self._ring = ring
        self._show = show
        self._writer = writer
        self._say = say
        self._malformed = 0
        self.failed = False

    def drain(self) -> None:
        """Take the ring's present content; messages put meanwhile may stay for the next call."""
        left = self._ring.block.size  # a daemon that never pauses must not keep this from ending
        while left > 0 and (message := self._ring.get()) is not None:
            left -= len(message) + 4
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
        self._show(name, decoded)
        writer = self._writer
        if writer is not None and not self.failed:
            self._guarded(lambda: writer.write(name, decoded))

    def flush(self) -> None:
        """Hand everything to the operating system."""
        if self._writer is not None and not self.failed:
            self._guarded(self._writer.flush)

    def finish(self) -> None:
        """Take what is left and complete the file."""
        self.drain()
        if self._writer is None:
            return
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
    log("recorder", "error", line)


class LiveView:
    """Sends the telemetry to its port, and the same with the texts to the panel's."""

    def __init__(self, settings: Telemetry, origin_monotonic_s: float) -> None:
        """origin_monotonic_s: cycle 0 on the monotonic clock, s."""
        self._batches = TelemetryBatches(settings)
        self._texts = PanelStream(origin_monotonic_s)
        self._send = telemetry_sender(settings.host, settings.port)
        self._send_to_panel = telemetry_sender(settings.host, settings.panel_port)

    def take(self, topic_name: str, message: msgspec.Struct) -> None:
        """Collect one message."""
        self._batches.take(topic_name, message)
        self._texts.take(message)

    def send_due(self, now_s: float) -> None:
        """Send what is due at `now_s`, s on the monotonic clock."""
        for datagram in self._texts.due(now_s):
            self._send_to_panel(datagram)
        for datagram in self._batches.due(now_s):
            self._send(datagram)
            self._send_to_panel(datagram)


def _shown(order: RecorderOrder, live: LiveView | None) -> Callable[[str, msgspec.Struct], None]:
    """Sends each message as telemetry, and prints /log as structured lines."""

    def show(topic_name: str, message: msgspec.Struct) -> None:
        if live is not None:
            live.take(topic_name, message)
        if isinstance(message, LogLine):
            with contextlib.suppress(OSError):
                line = log_line(
                    order.process_name,
                    message.level,
                    message.text,
                    time.time(),
                    time_s=round(message.time_s, 6),
                )
                print(line, file=sys.stderr, flush=True)

    return show


def _feed_watchdog(ring: SharedRing) -> None:
    """Feed the daemon's watchdog from a thread, which no stalled disk holds up, as long as messages are put."""
    if watchdog_period_s() is None:
        return
    watchdog, words = Watchdog(), ring.block.words

    def watch() -> None:
        with contextlib.suppress(ValueError):  # the memory is released: the recorder ends
            while True:
                watchdog.feed(words[1] + words[3], time.monotonic())  # what was put, and what found no room
                time.sleep(_WATCH_S)

    threading.Thread(target=watch, name="watchdog", daemon=True).start()


def main(ring_name: str, daemon: int) -> int:
    """Run until the daemon asks or is gone. Returns 0 when the whole recording is on disk."""
    stop = StopSignal()
    raise_session_priority(_NICENESS)
    warm_up()
    gc.freeze()  # what the imports made lives for ever: no collection need look at it again
    try:
        print(LOADED, flush=True)
        order = msgspec.msgpack.decode(sys.stdin.buffer.read(), type=RecorderOrder)
        ring = SharedRing(ring_name, create=False)
        writer = None if order.path is None else RecordingWriter(order.path, order.header)
    except (UserError, msgspec.DecodeError, BrokenPipeError) as error:
        print(error, flush=True)
        return 1
    telemetry = order.telemetry if order.telemetry is not None and order.telemetry.enabled else None
    live = LiveView(telemetry, order.header.origin_monotonic_s) if telemetry is not None else None
    drain = Drain(ring, writer, _say, _shown(order, live))
    print(READY, flush=True)
    _feed_watchdog(ring)
    sys.stdout.close()
    flushed = time.monotonic()
    # The parent of a process changes at the instant its parent is gone, and can never be a later process with
    # the same number: surer than to look the number up.
    while not stop and os.getppid() == daemon:
        drain.drain()
        if live is not None:
            live.send_due(time.monotonic())
        if time.monotonic() - flushed >= _FLUSH_S:
            drain.flush()
            flushed = time.monotonic()
        time.sleep(_PERIOD_S)
    drain.finish()
    ring.block.path.unlink(missing_ok=True)
    ring.close()
    return int(drain.failed)


if __name__ == "__main__":
    ring_name, daemon = sys.argv[1:]
    status = main(ring_name, int(daemon))
    sys.stderr.flush()
    os._exit(status)  # sys.stdout is closed: nothing is left to flush
