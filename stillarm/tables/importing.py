"""`stillarm import FILE --as DESCRIPTION -o REC`: the tables of a file become a recording, as the description says."""

import heapq
from collections.abc import Iterator
from dataclasses import dataclass
from math import isnan, nan
from operator import itemgetter
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from stillarm.common.datagrams.visual_sample import TrackingStatus
from stillarm.common.files.model import Model, load_model
from stillarm.common.files.typed_toml import read_toml_text
from stillarm.common.recording.header import imported_header
from stillarm.common.recording.topics import FastSample, ForeignColumns, FrameSample, PairSample
from stillarm.common.recording.writer import RecordingWriter
from stillarm.common.user_error import UserError
from stillarm.tables.description import NOTE_NAME, UNSTATED, ChannelEntry, Description, TableEntry, scale_of
from stillarm.tables.roles import BY_NAME, IGNORE, INPUT, OUTPUT, UNKNOWN
from stillarm.tables.table import Table, TableFile, as_floats
from stillarm.tables.timing import listed, times_s

LARGEST = 1e15  # beyond any measurement; estimators square what they are given
UNCOUNTED = -1
Floats = NDArray[np.float64]
Message = tuple[str, msgspec.Struct]


@dataclass(frozen=True)
class ImportedTables:
    """What came in. rows: by topic; unscaled: channels whose scale nobody knows, as 'column (role)'."""

    rows: dict[str, int]
    unscaled: tuple[str, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class _Rows:
    """Channels of one table that go to one topic: by role, or by their own name where that has no unit to keep."""

    topic: str
    times_s: Floats
    values: dict[str, Floats]
    kept: dict[str, Floats]


def import_tables(
    file: TableFile, description: Description, text: str, out: str | Path, model_file: Path | None = None
) -> ImportedTables:
    """Write a recording of a file's tables; its header keeps `text`, the description. Raises UserError.

    cycle = round(time_s / cycle_s) of the model, as for a CSV bundle.
    """
    model = load_model(model_file) if model_file else Model()
    notes = list(file.notes)
    blocks = [block for entry in description.tables for block in _blocks(file, entry, notes)]
    if not blocks:
        raise UserError(
            f'{file.name}: the description gives no channel a role; give one, or role = "unknown" to keep it'
        )
    _refuse_double_roles(blocks, file.name)
    blocks = _joined(blocks)
    header_notes = {"source": file.name, NOTE_NAME: text}
    if any(entry.rate_hz == UNSTATED and not entry.time_column for entry in description.tables):
        notes.append(
            "rate unknown: time is counted in samples, so 1 s stands for one sample and 1 Hz for one cycle a sample"
        )
    for block in blocks:
        header_notes |= _pair_notes(block, description, notes)
    header_notes |= {f"import_{number:02d}": note for number, note in enumerate(notes)}
    earliest = min(float(np.nanmin(block.times_s)) for block in blocks)
    origin_ns = max(0, -int(earliest // 1.0)) * 1_000_000_000
    model_text = read_toml_text(model_file) if model_file else ""
    rows: dict[str, int] = {}
    writer = RecordingWriter(out, imported_header(model_text, header_notes, origin_ns))
    try:
        streams = [_messages(block, model.timing.cycle_s) for block in blocks]
        for _, messages in heapq.merge(*streams, key=itemgetter(0)):
            for topic, message in messages:
                writer.write(topic, message)
                rows[topic] = rows.get(topic, 0) + 1
    finally:
        writer.close()
    return ImportedTables(rows, _unscaled(description), tuple(notes))


def _pair_notes(block: _Rows, description: Description, notes: list[str]) -> dict[str, str]:
    """What a recording with /pair says of its rate and columns, as `--map` writes it; a pair is evenly sampled."""
    if block.topic != "/pair":
        return {}
    steps = np.diff(block.times_s)
    usual = float(np.median(steps)) if len(steps) else 1.0
    if usual <= 0.0:
        raise UserError(
            "a pair of input and output needs a time that grows; correct time_column, or give rate_hz"
        )
    uneven = int(np.sum(np.abs(steps - usual) > 0.01 * usual))
    if uneven:
        notes.append(
            f"the pair's steps differ in {uneven} of {len(steps)} rows; it is taken as evenly sampled"
        )
    columns = {channel.role: channel.column for entry in description.tables for channel in entry.channels}
    # 12 digits: what rounding of the times leaves
    return {
        "input_column": columns[INPUT],
        "output_column": columns[OUTPUT],
        "rate_hz": repr(float(f"{1.0 / usual:.12g}")),
    }


def kept_name(entry: TableEntry, channel: ChannelEntry, many: bool) -> str:
    """Under which name a channel without a unit is kept: its own, with its table's where there are several."""
    return f"{entry.name}: {channel.column}" if many and entry.name else channel.column


def _unscaled(description: Description) -> tuple[str, ...]:
    found = []
    for entry in description.tables:
        for channel in entry.channels:
            if channel.role not in (UNKNOWN, IGNORE) and scale_of(channel) is None:
                found.append(f"{channel.column} ({channel.role})")
    return tuple(found)


def _blocks(file: TableFile, entry: TableEntry, notes: list[str]) -> Iterator[_Rows]:
    table = next((t for t in file.tables if t.name == entry.name), None)
    if table is None:
        if entry.name or len(file.tables) != 1:
            names = ", ".join(repr(t.name) for t in file.tables)
            raise UserError(f"{file.name}: no table {entry.name!r}; it holds {names}")
        table = file.tables[0]
    where = f"{file.name}: table {entry.name!r}" if entry.name else file.name
    time_s = times_s(table, entry, where)
    there = ~np.isnan(time_s)
    if not there.any():
        raise UserError(f"{where}: time_column {entry.time_column!r} holds no number; name another")
    if not there.all():
        notes.append(f"{where}: {int(np.sum(~there))} rows without a time left out")
    by_topic: dict[str, tuple[dict[str, Floats], dict[str, Floats]]] = {}
    many = len(file.tables) > 1
    home = _home(entry)
    for channel in entry.channels:
        if channel.role == IGNORE:
            continue
        role = BY_NAME[channel.role]
        values = _column(table, channel, where)[there]
        scale = scale_of(channel, where)
        topic = home if role.name == UNKNOWN else role.topic
        known, kept = by_topic.setdefault(topic, ({}, {}))
        if role.name == UNKNOWN or (scale is None and role.dimension):
            kept[kept_name(entry, channel, many)] = values
        elif role.name in known:
            raise UserError(
                f'{where}: two channels have the role {role.name}; give one of them role = "unknown"'
            )
        else:
            known[role.name] = values if scale is None else scale * values + channel.offset
            _refuse_large(known[role.name], channel, where)
    for topic, (known, kept) in by_topic.items():
        yield _Rows(topic, time_s[there], known, kept)


def _home(entry: TableEntry) -> str:
    """Topic for the channels without a role: that of the channels with one."""
    topics = {
        BY_NAME[channel.role].topic for channel in entry.channels if channel.role not in (UNKNOWN, IGNORE)
    }
    return next((topic for topic in ("/fast", "/frames", "/pair") if topic in topics), "/fast")


def _column(table: Table, channel: ChannelEntry, where: str) -> Floats:
    if channel.column not in table.columns:
        raise UserError(f"{where}: column {channel.column!r}: not there; it holds {listed(table)}")
    return as_floats(table.columns[channel.column])


def _refuse_large(values: Floats, channel: ChannelEntry, where: str) -> None:
    largest = float(np.nanmax(np.abs(values), initial=0.0))
    if largest > LARGEST:
        raise UserError(
            f"{where}: column {channel.column!r} reaches {largest:.3g}; at most {LARGEST:g} is a measurement; correct "
            'its scale, or give it role = "unknown"'
        )


def _refuse_double_roles(blocks: list[_Rows], name: str) -> None:
    seen: set[str] = set()
    for block in blocks:
        for role in block.values:
            if role in seen:
                raise UserError(
                    f'{name}: two channels have the role {role}; give one of them role = "unknown"'
                )
            seen.add(role)
    if (INPUT in seen) != (OUTPUT in seen):
        raise UserError(
            f"{name}: role input needs one channel with role output beside it, and the other way round"
        )


def _joined(blocks: list[_Rows]) -> list[_Rows]:
    """Blocks of one topic and the same times as one block; others stay apart, and their rows are sorted in."""
    found: list[_Rows] = []
    for block in blocks:
        for index, other in enumerate(found):
            if other.topic == block.topic and np.array_equal(other.times_s, block.times_s):
                found[index] = _Rows(
                    block.topic, block.times_s, other.values | block.values, other.kept | block.kept
                )
                break
        else:
            found.append(block)
    return found


def _messages(block: _Rows, cycle_s: float) -> Iterator[tuple[float, list[Message]]]:
    columns = {name: values.tolist() for name, values in block.values.items()}
    kept = {
        name: [None if isnan(value) else value for value in values.tolist()]
        for name, values in block.kept.items()
    }
    for index, time_s in enumerate(block.times_s.tolist()):
        row = {name: values[index] for name, values in columns.items()}
        found: list[Message] = [(block.topic, _MAKE[block.topic](time_s, cycle_s, index, row))]
        if kept:
            held = {name: values[index] for name, values in kept.items()}
            topic = block.topic if block.topic in ("/fast", "/frames") else "/fast"
            found.append((f"{topic}/columns", ForeignColumns(time_s, held)))
        yield time_s, found


def _fast(time_s: float, cycle_s: float, index: int, row: dict[str, Any]) -> FastSample:
    return FastSample(time_s=time_s, cycle=round(time_s / cycle_s), **row)


def _frame(time_s: float, cycle_s: float, index: int, row: dict[str, Any]) -> FrameSample:
    started_s = row.pop("started_s", nan)
    counted = row.pop("frame", float(index))
    seen = row.get("displacement_px", nan)
    return FrameSample(
        time_s=time_s,
        cycle=round(time_s / cycle_s),
        frame=UNCOUNTED if isnan(counted) else round(counted),
        received_s=time_s,
        started_s=started_s,
        started_cycle=UNCOUNTED if isnan(started_s) else round(started_s / cycle_s),
        status=int(TrackingStatus.NO_IMAGE if isnan(seen) else TrackingStatus.MEASURED),
        **row,
    )


def _pair(time_s: float, cycle_s: float, index: int, row: dict[str, float]) -> PairSample:
    return PairSample(time_s, row[INPUT], row[OUTPUT])


_MAKE = {"/fast": _fast, "/frames": _frame, "/pair": _pair}
