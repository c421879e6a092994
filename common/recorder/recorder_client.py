"""The daemon's side of the recorder: messages go into a ring in shared memory, a process of its own writes
them.

Writing a recording sometimes takes milliseconds. A put() always takes microseconds, and never waits.
"""

import contextlib
import os
import secrets
import subprocess
from pathlib import Path

import msgspec

from stillarm.common.files.configuration import Telemetry
from stillarm.common.memory.shared_memory import SharedRing
from stillarm.common.process.child_process import next_line, start_module
from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recording.topics import TOPICS
from stillarm.common.user_error import UserError

_RING_BYTES = 8 << 20  # some ten seconds of every topic at 1 kHz, should the disk stall
_START_S = 20.0
RECORDING_CUT = (
    "the recording is not complete: its process ended early, or the disk was full; "
    "mend it with `stillarm recover`"
)
LOADED = "loaded"  # the recorder's first line: imported and warmed up, waiting for its order
READY = "ready"  # its second one: the file is open
_PREFIX = [bytes([index]) for index in range(len(TOPICS))]


class RecorderOrder(msgspec.Struct, frozen=True):
    """What a recorder is started with."""

    header: RecordingHeader
    path: str | None
    telemetry: Telemetry | None
    process_name: str


class RecorderClient:
    """A recorder process and the way to it. One process and one thread may use it, because the ring has one writer."""

    def __init__(self, process: subprocess.Popen[bytes], ring: SharedRing) -> None:
        """Use launch() or start()."""
        self._process = process
        self._ring = ring
        self._answer: str | None = None  # the first line that the process said
        self._begun = False
        self._encode = msgspec.msgpack.Encoder().encode
        self._put = ring.put

    @classmethod
    def launch(cls, *, ring_bytes: int = _RING_BYTES, stderr: int | None = None) -> "RecorderClient":
        """Start the recorder's process, and do not wait: it loads and warms up meanwhile. begin() gives it its file.

        stderr: where /log is printed, as subprocess.Popen takes it; None: where this process prints.
        Raises UserError when there is no shared memory for the ring.
        """
        name = f"recorder-{os.getpid()}-{secrets.token_hex(4)}"
        ring = SharedRing(name, ring_bytes, create=True)
        try:
            process = start_module(
                "stillarm.common.recorder.recorder_process",
                name,
                str(os.getpid()),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=stderr,
                start_new_session=True,  # where neither Ctrl-C nor a hang-up of the terminal reaches it
            )
        except BaseException:
            ring.close()
            raise
        return cls(process, ring)

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
        client = cls.launch(ring_bytes=ring_bytes)
        try:
            client.begin(path, header, telemetry=telemetry, process_name=process_name)
        except BaseException:
            client.close()
            raise
        return client

    def wait_until_loaded(self) -> None:
        """Wait until the process has warmed up; after that its start costs no processor time.

        begin() reports a process that ends before, or takes too long.
        """
        if self._answer is None:
            self._answer = next_line(self._process, _START_S)

    def begin(
        self,
        path: str | Path | None,
        header: RecordingHeader,
        *,
        telemetry: Telemetry | None = None,
        process_name: str = "recorder",
    ) -> None:
        """Give the launched recorder its file, and wait until that is open; as start(). Raises UserError."""
        place = None if path is None else str(Path(path).absolute())
        process = self._process
        assert process.stdin is not None and process.stdout is not None
        self.wait_until_loaded()
        answer = self._answer
        if answer == LOADED:
            with contextlib.suppress(BrokenPipeError), process.stdin as stdin:
                stdin.write(msgspec.msgpack.encode(RecorderOrder(header, place, telemetry, process_name)))
            answer = next_line(process, _START_S)
        process.stdout.close()
        if answer == READY:
            self._begun = True
            return
        process.kill()
        process.wait()
        where = place or "telemetry"
        if answer == "":
            raise UserError(
                f"{where}: the recorder ended before it began; what it said on standard error tells why"
            )
        raise UserError(
            answer
            or f"{where}: the recorder did not start within {_START_S:.0f} s; is the machine overloaded?"
        )

    def put(self, topic_index: int, message: msgspec.Struct) -> None:
        """Hand over a message; `topic_index` from stillarm.common.recording.topics.TOPIC_INDEX.

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

        Returns whether it did, in time and without an error; may be called twice. A recorder that never began has
        nothing to complete.
        """
        if not self._begun:
            self._abandon()
            return True
        self._process.terminate()  # to the recorder this means: finish
        try:
            complete = self._process.wait(timeout_s) == 0
        except subprocess.TimeoutExpired:  # a disk that hangs; the recorder goes on by itself
            return False
        self._ring.close()
        return complete

    def _abandon(self) -> None:
        """End a process that was given no file."""
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with contextlib.suppress(BrokenPipeError):
                    pipe.close()
        self._process.kill()
        self._process.wait()
        self._ring.close()
