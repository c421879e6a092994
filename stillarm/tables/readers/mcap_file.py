"""MCAP with anybody's topics, and ROS 2 bags stored as MCAP: one table a topic.

JSON messages are read here, ROS 2's CDR by rosbags with the schemas that the file carries. Topics in other encodings
are named in the notes. A cut file gives what is whole before the cut.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from mcap.exceptions import McapError
from mcap.records import Channel, Message, Metadata, Schema
from mcap.stream_reader import StreamReader

from stillarm.common.user_error import UserError
from stillarm.tables.readers.array_groups import plain
from stillarm.tables.readers.flat_message import INSTANT_SUFFIX, flat
from stillarm.tables.readers.ros2_messages import cdr_decoder
from stillarm.tables.table import Table, TableFile, Values

LOG_TIME = "log_time_ns"
Decode = Callable[[bytes], Any]


@dataclass
class _Topic:
    """Rows of one topic as they arrive; decode is None where its encoding is not read."""

    name: str
    decode: Decode | None
    log_ns: list[int] = field(default_factory=list)
    rows: list[dict[str, float | int]] = field(default_factory=list)
    failed: int = 0


def read(path: Path) -> TableFile:
    """Read an MCAP file, or a folder of them (a ROS 2 bag). Raises UserError."""
    notes: list[str] = []
    topics: dict[str, _Topic] = {}
    for file in _files(path):
        _read_one(file, topics, notes)
    tables = tuple(_table(topic) for topic in topics.values() if topic.rows)
    for topic in topics.values():
        if topic.failed:
            notes.append(f"{topic.name}: {topic.failed} messages could not be decoded; left out")
    if not tables:
        raise UserError(
            f"{path}: no topic with numbers that are read ({'; '.join(notes)[:200] or 'no messages at all'})"
        )
    return TableFile(path.name, "mcap", tables, tuple(notes))


def _files(path: Path) -> list[Path]:
    if not path.is_dir():
        return [path]
    found = sorted(path.glob("*.mcap"))
    if not found and list(path.glob("*.db3")):
        raise UserError(f"{path}: a ROS 2 bag in SQLite; convert it with `ros2 bag convert` to storage mcap")
    if not found and (path / "fast.csv").exists():
        raise UserError(f"{path}: a CSV bundle; import it without --look and --as, or name its fast.csv")
    if not found:
        raise UserError(f"{path}: a folder without .mcap; name a file, or a ROS 2 bag stored as MCAP")
    return found


def _read_one(path: Path, topics: dict[str, _Topic], notes: list[str]) -> None:
    schemas: dict[int, Schema] = {}
    channels: dict[int, _Topic] = {}
    with path.open("rb") as file:
        for record in _records(file, path, notes):
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel) and record.id not in channels:
                topic = topics.get(record.topic)
                if topic is None:
                    decode, problem = _decoder(record, schemas.get(record.schema_id))
                    topic = topics[record.topic] = _Topic(record.topic, decode)
                    notes += [f"{record.topic}: {problem}"] if problem else []
                channels[record.id] = topic
            elif isinstance(record, Message) and record.channel_id in channels:
                _take(channels[record.channel_id], record)
            elif isinstance(record, Metadata) and record.name == "stillarm":
                notes.append("written by stillarm: every command takes it as it is")


def _records(file: Any, path: Path, notes: list[str]) -> Iterator[Any]:
    """The records up to the end, or to the first damage, which is noted."""
    try:
        yield from StreamReader(file).records
    except (McapError, OSError, ValueError, RuntimeError, EOFError, KeyError) as error:
        said = " ".join(str(error).split())[:60] or type(error).__name__
        notes.append(f"{path.name}: cut or damaged ({said}); what is whole before is read")


def _decoder(channel: Channel, schema: Schema | None) -> tuple[Decode | None, str]:
    encoding = channel.message_encoding
    if encoding == "json":
        return msgspec.json.decode, ""
    if encoding == "cdr" and schema is not None:
        return cdr_decoder(schema.name, schema.encoding, schema.data)
    return None, f"message encoding {encoding[:20]!r} is not read (json and ROS 2's cdr are); left out"


def _take(topic: _Topic, message: Message) -> None:
    if topic.decode is None:
        return
    try:
        row = flat(topic.decode(message.data))
    except Exception:  # a message that does not fit its schema raises anything in a foreign decoder
        topic.failed += 1
        return
    if row:
        topic.log_ns.append(message.log_time)
        topic.rows.append(row)


def _table(topic: _Topic) -> Table:
    names = list(dict.fromkeys(name for row in topic.rows for name in row))
    columns: dict[str, Values] = {LOG_TIME: np.array(topic.log_ns, dtype=np.uint64).astype(np.int64)}
    for name in names:
        columns[name] = _column([row.get(name) for row in topic.rows])
    units = {name: "ns" for name in columns if name == LOG_TIME or name.endswith(INSTANT_SUFFIX)}
    return Table(topic.name, columns, units)


def _column(values: list[float | int | None]) -> Values:
    if all(isinstance(value, int) for value in values):
        try:
            return np.array(values, dtype=np.int64)
        except OverflowError:
            pass
    return plain(np.array([np.nan if value is None else value for value in values], dtype=np.float64))
