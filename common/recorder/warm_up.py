"""Runs the recorder's hot path once, on blank messages and a file in memory, before the daemon counts on it.

It makes what would otherwise be made on first use: schemas, encoders, the compressor's context. The recorder may share
a processor with the tracker: 40 ms of first calls during the first cycles would make the first images late.
"""

import io

import msgspec

from stillarm.common.datagrams.fields import plain_types
from stillarm.common.files.configuration import Telemetry
from stillarm.common.recorder.telemetry import TelemetryBatches
from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recording.topics import TOPICS
from stillarm.common.recording.writer import RecordingWriter

_ROUNDS = 20
_BLANK: dict[object, object] = {float: 0.0, int: 0, str: "", bool: False, list[float]: [0.0]}
_HEADER = RecordingHeader(
    program_version="", configuration="", configuration_name="", model="", method="", kind="live"
)


def warm_up() -> None:
    """Decode, write, compress and batch each topic's message a few times; nothing of it remains."""
    writer = RecordingWriter(io.BytesIO(), _HEADER)
    batches = TelemetryBatches(Telemetry())
    for topic in TOPICS:
        encoded = msgspec.msgpack.encode(blank_message(topic.message))
        decoder = msgspec.msgpack.Decoder(topic.message)
        for _ in range(_ROUNDS):
            message = decoder.decode(encoded)
            writer.write(topic.name, message)
            batches.take(topic.name, message)
    writer.flush()
    batches.due(0.0)
    writer.close()


def blank_message(kind: type[msgspec.Struct]) -> msgspec.Struct:
    """A message of that type whose required fields are zero or empty."""
    types = plain_types(kind)
    return kind(*(_BLANK.get(types[f.name], {}) for f in msgspec.structs.fields(kind) if f.required))
