"""Recordings written by a second process, so that the simulation has a core to itself.

Messages travel in batches through a pipe, which blocks when the writer is behind: none is lost, and the files
depend on the messages alone.
"""

import multiprocessing
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path

import msgspec

from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recording.topics import TOPIC_INDEX, TOPICS
from stillarm.common.recording.writer import RecordingWriter
from stillarm.common.user_error import UserError

_BATCH = 2000

_Packet = tuple[int, int, bytes]  # file, topic index, message


class RecordingSink:
    """One of the files of a RecordingProcess; takes messages as a RecordingWriter does."""

    def __init__(self, process: "RecordingProcess", file: int) -> None:
        """Use RecordingProcess.sinks."""
        self._process = process
        self._file = file

    def write(self, topic_name: str, message: msgspec.Struct) -> None:
        """Append a message of a topic of the table."""
        self._process.add(self._file, TOPIC_INDEX[topic_name], message)


class RecordingProcess:
    """Writes several recordings at once. Raises UserError, on start or on close, for what could not be written."""

    def __init__(self, files: list[tuple[Path, RecordingHeader]]) -> None:
        """Begin the files."""
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        arguments = (theirs, [(str(path), msgspec.msgpack.encode(header)) for path, header in files])
        self._process = context.Process(target=_write_all, args=arguments, name="recording", daemon=True)
        self._process.start()
        theirs.close()
        self._batch: list[_Packet] = []
        self._encode = msgspec.msgpack.Encoder().encode
        self.sinks = [RecordingSink(self, file) for file in range(len(files))]

    def add(self, file: int, topic: int, message: msgspec.Struct) -> None:
        """Take one message."""
        self._batch.append((file, topic, self._encode(message)))
        if len(self._batch) >= _BATCH:
            self._send()

    def _send(self) -> None:
        batch, self._batch = self._batch, []
        try:
            if self._connection.poll():  # nothing is said before the end but a failure
                failure = self._connection.recv()
                self._connection.close()
                self._process.join()
                raise UserError(failure)
            self._connection.send_bytes(self._encode(batch))
        except (EOFError, OSError):
            raise UserError("the recording's process died before the simulation ended") from None

    def close(self) -> None:
        """Complete the files; may be called twice. Raises UserError when one could not be written."""
        if self._connection.closed:
            return
        failure: str | None = None
        with suppress(EOFError, OSError):
            if self._batch:
                self._connection.send_bytes(self._encode(self._batch))
            self._connection.send_bytes(b"")
            failure = self._connection.recv()
        self._process.join()
        self._connection.close()
        if failure is None:
            raise UserError(f"the recording's process died (exit status {self._process.exitcode})")
        if failure:
            raise UserError(failure)


def _write_all(connection: Connection, files: list[tuple[str, bytes]]) -> None:
    writers: list[RecordingWriter] = []
    failure = ""
    try:
        for path, header in files:
            writers.append(RecordingWriter(path, msgspec.msgpack.decode(header, type=RecordingHeader)))
        _write_batches(connection, writers)
    except UserError as error:
        failure = str(error)
        connection.send(failure)  # at once: the simulation need not go on
        _drain(connection)
    except EOFError:
        failure = "the simulation died"  # nobody is left to be told
    told = bool(failure)
    for writer in writers:
        try:
            writer.close()
        except UserError as error:
            failure = failure or str(error)
    if not told:
        connection.send(failure)


def _write_batches(connection: Connection, writers: list[RecordingWriter]) -> None:
    batches = msgspec.msgpack.Decoder(list[_Packet])
    decoders = [msgspec.msgpack.Decoder(topic.message) for topic in TOPICS]
    names = [topic.name for topic in TOPICS]
    while data := connection.recv_bytes():
        for file, topic, message in batches.decode(data):
            writers[file].write(names[topic], decoders[topic].decode(message))


def _drain(connection: Connection) -> None:
    """Empty the pipe, so that the simulation does not wait for ever."""
    try:
        while connection.recv_bytes():
            pass
    except EOFError:
        return
