"""The daemon's side of the recorder: messages go into a ring in shared memory, a process of its own writes
them.

A write of a recording takes milliseconds now and then; a put() takes microseconds always, and never waits.
"""

import contextlib
import os
import secrets
import selectors
import subprocess
from pathlib import Path

import msgspec

from common.child_process import start_module
from common.configuration import Telemetry
from common.recording.header import RecordingHeader
from common.recording.topics import TOPICS
from common.shared_memory import SharedRing
from common.user_error import UserError

_RING_BYTES = 8 << 20  # some ten seconds of every topic at 1 kHz, should the disk stall
_START_S = 20.0
RECORDING_CUT = (
    "the recording is not complete: its process ended early, or the disk was full; "
    "mend it with `stillarm recover`"
)
_PREFIX = [bytes([index]) for index in range(len(TOPICS))]


class RecorderOrder(msgspec.Struct, frozen=True):
    """What a recorder is started with."""

    header: RecordingHeader
    path: str | None
    telemetry: Telemetry | None
    process_name: str


class RecorderClient:
    """A recorder process and the way to it. Of one process and one thread: the ring has one writer."""

    def __init__(self, process: subprocess.Popen[bytes], ring: SharedRing) -> None:
        """Use start()."""
        self._process = process
        self._ring = ring
        self._encode = msgspec.msgpack.Encoder().encode
        self._put = ring.put

    @classmethod
    def start(
        cls,
        path: str | Path | None,
        header: RecordingHeader,
        *,
        ring_bytes: int = _RING_BYTES,
        telemetry: Telemetry | None = None,
        process_name: str = "recorder",
    ) -> "RecorderClient":
        """Start the recorder and wait until its file is open.

        path: None records nothing; the telemetry is sent, and /log printed, all the same. process_name: in log lines.
        Raises UserError when the file cannot be written or there is no shared memory for the ring.
        """
        name = f"recorder-{os.getpid()}-{secrets.token_hex(4)}"
        ring = SharedRing(name, ring_bytes, create=True)
        try:
            order = RecorderOrder(
                header, None if path is None else str(Path(path).absolute()), telemetry, process_name
            )
            process = _spawn(order, name)
        except BaseException:
            ring.close()
            raise
        return cls(process, ring)

    def put(self, topic_index: int, message: msgspec.Struct) -> None:
        """Hand over a message; `topic_index` from common.recording.topics.TOPIC_INDEX.

        Never waits. A message for which there is no room is lost, and counted.
        """
        self._put(_PREFIX[topic_index] + self._encode(message))

    @property
    def lost(self) -> int:
        """How many messages found no room."""
        return self._ring.lost

    @property
    def process_id(self) -> int:
        """The number of the recorder's process."""
        return self._process.pid

    def alive(self) -> bool:
        """Whether the recorder still runs; never waits."""
        return self._process.poll() is None

    def close(self, timeout_s: float = 10.0) -> bool:
        """Have the recorder write what it was given and complete the file, waiting up to `timeout_s`.

        Returns whether it did, in time and without an error of its own; may be called twice.
        """
        self._process.terminate()  # to the recorder this means: finish
        try:
            complete = self._process.wait(timeout_s) == 0
        except subprocess.TimeoutExpired:  # a disk that hangs; the recorder goes on by itself
            return False
        self._ring.close()
        return complete


def _spawn(order: RecorderOrder, ring_name: str) -> subprocess.Popen[bytes]:
    """Start the recorder in a session of its own, where neither Ctrl-C nor a hang-up of the terminal reaches
    it.
    """
    process = start_module(
        "common.recording.recorder_process",
        ring_name,
        str(os.getpid()),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        start_new_session=True,
    )
    assert process.stdin is not None and process.stdout is not None
    with contextlib.suppress(BrokenPipeError), process.stdin as stdin:
        stdin.write(msgspec.msgpack.encode(order))
    with process.stdout as stdout, selectors.DefaultSelector() as selector:
        selector.register(stdout, selectors.EVENT_READ)
        answered = bool(selector.select(_START_S))
        answer = stdout.readline().decode().strip() if answered else ""
    if answer == "ready":
        return process
    process.kill()
    process.wait()
    place = order.path or "telemetry"
    if answered and not answer:
        raise UserError(
            f"{place}: the recorder ended before it began; what it said on standard error tells why"
        )
    raise UserError(
        answer or f"{place}: the recorder did not start within {_START_S:.0f} s; is the machine overloaded?"
    )
