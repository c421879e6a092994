"""Writes a recording: MCAP, JSON messages with a JSON schema each, zstd chunks.

Specification of the container: https://mcap.dev/spec. log_time = header.origin_unix_ns + time_s, in
nanoseconds.
"""

from pathlib import Path
from typing import IO

import msgspec
from mcap.data_stream import RecordBuilder
from mcap.records import DataEnd, Footer
from mcap.writer import MCAP0_MAGIC, CompressionType, Writer

from stillarm.common.recording.append_file import AppendFile
from stillarm.common.recording.chunk_indices import PackedChunkIndices
from stillarm.common.recording.header import METADATA_NAME, NOTES_NAME, RecordingHeader, header_metadata
from stillarm.common.recording.json_schema import json_schema
from stillarm.common.recording.topics import TOPIC_INDEX, TOPICS
from stillarm.common.user_error import UserError, reason_of

_CHUNK_BYTES = 1 << 20
_CHUNK_NS = 500_000_000  # of log time: what a killed writer may lose
_CHUNK_INDICES = "_Writer__chunk_indices"  # the library keeps objects there, for good
_MAX_TIME_S = 9.2e9
_MAX_LOG_TIME_NS = (1 << 63) - 1  # some readers take it as signed


class RecordingWriter:
    """One recording being written. The same header and messages give the same bytes.

    After a failed write (disk full) the file is ended so that it opens, and every call but close() raises
    UserError.
    """

    def __init__(self, path_or_file: str | Path | IO[bytes], header: RecordingHeader) -> None:
        """Make the file and write its header. Raises UserError when that cannot be done."""
        self._file = AppendFile(path_or_file)
        self._origin_ns = header.origin_unix_ns
        self._writer = Writer(self._file, chunk_size=_CHUNK_BYTES, compression=CompressionType.ZSTD)  # type: ignore[arg-type]
        setattr(self._writer, _CHUNK_INDICES, PackedChunkIndices())
        self._encode = msgspec.json.Encoder().encode
        self._channels: dict[str, int] = {}
        self._sequences = [0] * (len(TOPICS) + 1)
        self._chunk_start_ns: int | None = None
        self._last_ns = 0
        self._failure: str | None = None
        self._closed = False
        try:
            # no version of a package: the bytes depend on what is given only
            self._writer.start(library="stillarm")
            self._writer.add_metadata(METADATA_NAME, header_metadata(header))
            self._writer.add_metadata(NOTES_NAME, dict(sorted(header.notes.items())))
        except OSError as error:
            raise self._fail(error) from None

    def write(self, topic_name: str, message: msgspec.Struct) -> None:
        """Append a message of a topic of the table; its time is message.time_s.

        A time that no log time can hold (not finite, beyond 290 years) takes that of the message before.
        Raises UserError when writing failed.
        """
        if self._failure:
            raise UserError(self._failure)
        channel = self._channels.get(topic_name) or self._register(topic_name)
        time_s: float = message.time_s  # type: ignore[attr-defined]
        if -_MAX_TIME_S <= time_s <= _MAX_TIME_S:
            self._last_ns = min(max(0, self._origin_ns + round(time_s * 1e9)), _MAX_LOG_TIME_NS)
        log_ns = self._last_ns
        sequence = self._sequences[channel]
        self._sequences[channel] = (sequence + 1) & 0xFFFFFFFF
        try:
            if self._chunk_start_ns is None:
                self._chunk_start_ns = log_ns
            elif not 0 <= log_ns - self._chunk_start_ns < _CHUNK_NS:
                self._writer.flush()  # type: ignore[no-untyped-call]
                self._chunk_start_ns = log_ns
            self._writer.add_message(channel, log_ns, self._encode(message), log_ns, sequence)
        except OSError as error:
            raise self._fail(error) from None

    def flush(self) -> None:
        """Hand to the operating system everything written so far. Raises UserError when writing failed."""
        if self._failure:
            raise UserError(self._failure)
        try:
            self._writer.flush()  # type: ignore[no-untyped-call]
        except OSError as error:
            raise self._fail(error) from None
        self._chunk_start_ns = None

    def close(self) -> None:
        """Complete the file; may be called twice. Raises UserError when that failed, or writing had failed before."""
        if self._closed:
            return
        self._closed = True
        if self._failure is None:
            try:
                self._writer.finish()  # type: ignore[no-untyped-call]
            except OSError as error:
                self._fail(error)
        self._file.close()
        if self._failure:
            raise UserError(self._failure)

    def _register(self, topic_name: str) -> int:
        if topic_name not in TOPIC_INDEX:
            raise ValueError(f"no such topic: {topic_name}")
        message = TOPICS[TOPIC_INDEX[topic_name]].message
        schema = self._writer.register_schema(
            f"stillarm.{message.__name__}", "jsonschema", json_schema(message)
        )
        channel = self._writer.register_channel(topic_name, "json", schema)
        self._channels[topic_name] = channel
        return channel

    def _fail(self, error: OSError) -> UserError:
        """End the file after its last whole record, in the fewest bytes that MCAP allows: there may be no room."""
        end = RecordBuilder()
        DataEnd(0).write(end)
        Footer(summary_start=0, summary_offset_start=0, summary_crc=0).write(end)
        try:
            self._file.write(end.end() + MCAP0_MAGIC)  # type: ignore[no-untyped-call]
            state = "what was written before is complete"
        except OSError:
            state = "what was written before can be read, and mended with `stillarm recover`"
        self._failure = (
            f"{self._file.name}: cannot be written any further ({reason_of(error)}); {state}; free some space"
        )
        return UserError(self._failure)
