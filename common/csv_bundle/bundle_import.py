"""`stillarm import DIR -o REC`: a CSV bundle becomes a recording that replay and diagnose read like any other."""

import difflib
import heapq
from collections.abc import Iterator
from math import isnan
from operator import itemgetter
from pathlib import Path
from typing import Any

import msgspec

from stillarm.common.csv_bundle.csv_table import (
    CsvTable,
    booleans,
    floats,
    integers,
    numbers_or_texts,
    read_csv,
    read_text,
)
from stillarm.common.datagrams.fields import plain_types
from stillarm.common.datagrams.visual_sample import TrackingStatus
from stillarm.common.files.model import Model, load_model
from stillarm.common.recording.header import imported_header
from stillarm.common.recording.topics import FastSample, ForeignColumns, FrameSample
from stillarm.common.recording.writer import RecordingWriter
from stillarm.common.user_error import UserError

UNCOUNTED = -1  # a frame number that is not there; a cycle that is not known
_MAX_TIME_S = 9e9  # what fits a log time in nanoseconds
_LARGEST = 1e15  # beyond any measurement; estimators square what they are given
_TIMES = ("time_s", "received_s", "started_s")  # have a bound of their own
_PURPOSE = {"time_s": "the time of a row", "received_s": "when the controller read the frame"}


class ImportReport(msgspec.Struct, frozen=True):
    """What came in. not_measured, unknown: columns as 'file: column'; notes: lines that the user should read."""

    fast_rows: int
    frame_rows: int
    model_given: bool
    not_measured: list[str]
    unknown: list[str]
    notes: list[str]


def import_bundle(directory: str | Path, out_path: str | Path) -> ImportReport:
    """Read fast.csv, frames.csv (if there) and model.toml (if there) of a folder; write the recording.

    cycle = round(time_s / cycle_s) of the model; times are kept as given, also where the clock repeats or
    steps back (a clock step is something to be diagnosed, not refused). Raises UserError, one line, naming
    file, line, column and value.
    """
    directory = Path(directory)
    if not directory.is_dir():
        raise UserError(
            f"{directory}: no folder; name one that holds fast.csv (a single file comes in with --map)"
        )
    if not (directory / "fast.csv").exists():
        raise UserError(
            f"{directory / 'fast.csv'}: not there; the folder needs one with a column time_s; for images alone, write "
            "one with that column alone, a row every cycle from the first frame to the last"
        )
    model_file = directory / "model.toml"
    model_given = model_file.exists()
    model = load_model(model_file) if model_given else Model()
    notes: list[str] = []
    if not model_given:
        notes.append(
            "model.toml: none given, every key takes its default; `stillarm calibrate` finds what is missing"
        )
    fast = read_csv(directory / "fast.csv")
    frames_file = directory / "frames.csv"
    frames = read_csv(frames_file) if frames_file.exists() else None
    cycle_s = model.timing.cycle_s
    fast_rows = _fast_samples(fast, cycle_s, notes)
    frame_rows = _frame_samples(frames, cycle_s, notes) if frames else []
    tables = [(fast, FastSample, _FAST_CONTRACT)] + (
        [(frames, FrameSample, _FRAMES_CONTRACT)] if frames else []
    )
    unknown = [
        f"{Path(table.name).name}: {name}" for table, kind, _ in tables for name in _unknown(table, kind)
    ]
    for table, kind, _ in tables:
        notes.extend(_unknown_notes(table, kind))
    header_notes = {"source": directory.resolve().name}
    header_notes |= {f"import_{number:02d}": note for number, note in enumerate(notes)}
    # Log times are never negative: a clock that starts below zero is shifted by whole seconds.
    origin_s = max(0, -int(min(row.time_s for row in fast_rows) // 1.0))
    model_text = read_text(model_file) if model_given else ""
    writer = RecordingWriter(out_path, imported_header(model_text, header_notes, origin_s * 1_000_000_000))
    try:
        streams = _with_foreign("/fast", fast_rows, fast), _with_foreign("/frames", frame_rows, frames)
        # Ordered by time; each stream keeps its own order, even where its clock steps back.
        for _, messages in heapq.merge(*streams, key=itemgetter(0)):
            for topic, message in messages:
                writer.write(topic, message)
    finally:
        writer.close()
    return ImportReport(
        fast_rows=len(fast_rows),
        frame_rows=len(frame_rows),
        model_given=model_given,
        not_measured=[
            f"{Path(table.name).name}: {name}"
            for table, _, contract in tables
            for name in contract
            if name not in table.columns
        ],
        unknown=unknown,
        notes=notes,
    )


_FAST_CONTRACT = (
    "acceleration_m_s2",
    "joint_velocity_command_rad_s",
    "joint_velocity_reference_rad_s",
    "joint_position_rad",
    "joint_velocity_rad_s",
    "deflection_m",
    "joint_torque_n_m",
)
_FRAMES_CONTRACT = (
    "frame",
    "started_s",
    "displacement_px",
    "captured_s",
    "exposure_s",
    "features",
    "inliers",
)


def known_columns(kind: type[msgspec.Struct]) -> list[str]:
    """Columns of a bundle's file: the fields of its messages. A frame's only time is received_s."""
    return [name for name in kind.__struct_fields__ if not (kind is FrameSample and name == "time_s")]


def _unknown(table: CsvTable, kind: type[msgspec.Struct]) -> list[str]:
    known = known_columns(kind)
    return [name for name in table.columns if name not in known]


def _unknown_notes(table: CsvTable, kind: type[msgspec.Struct]) -> Iterator[str]:
    for name in _unknown(table, kind):
        near = difflib.get_close_matches(name, known_columns(kind), n=1, cutoff=0.8)
        hint = f"; if {near[0]} is meant, rename it" if near else ""
        yield f"{Path(table.name).name}: column {name} is not known; kept, not used{hint}"


def _values(table: CsvTable, kind: type[msgspec.Struct]) -> dict[str, list[Any]]:
    """The known columns that are there, as numbers."""
    found: dict[str, list[Any]] = {}
    kinds = plain_types(kind)
    for name in known_columns(kind):
        if name not in table.columns:
            continue
        if kinds[name] is float:
            found[name] = floats(table, name)
            for row, value in enumerate(found[name]):
                if abs(value) > _LARGEST and name not in _TIMES:
                    raise table.error(row, name, f"a number of at most {_LARGEST:g} in size is needed")
        elif kinds[name] is bool:
            found[name] = booleans(table, name)
        else:
            found[name] = integers(table, name, 0 if name in ("features", "inliers") else UNCOUNTED)
    return found


def _times(table: CsvTable, values: dict[str, list[Any]], column: str, notes: list[str]) -> list[float]:
    """The column that gives each row its time; notes where it does not increase."""
    if column not in table.columns:
        near = difflib.get_close_matches(column, list(table.columns), n=1)
        hint = f"; rename {near[0]}, if that is it" if near else ""
        raise UserError(f"{table.name}: no column {column} ({_PURPOSE[column]}, s): it is needed{hint}")
    times: list[float] = values[column]
    for row, time_s in enumerate(times):
        if isnan(time_s) or abs(time_s) > _MAX_TIME_S:
            raise table.error(
                row, column, f"a time in seconds is needed in every row, at most {_MAX_TIME_S:g}"
            )
    back = [row for row in range(1, len(times)) if times[row] <= times[row - 1]]
    if back:
        first = back[0]
        notes.append(
            f"{Path(table.name).name}: {column} repeats or steps back in {len(back)} of {len(times)} "
            f"rows, first in line {table.lines[first]}: {times[first]!r} after {times[first - 1]!r}; "
            "kept in the file's order, and of rows of one cycle or before it replay takes the first; if they are "
            "only out of order, sort them by time and import again"
        )
    return times


def _fast_samples(table: CsvTable, cycle_s: float, notes: list[str]) -> list[FastSample]:
    if not table.lines:
        raise UserError(f"{table.name}: no rows; at least one with a time_s is needed")
    values = _values(table, FastSample)
    times = _times(table, values, "time_s", notes)
    _fill(values, "cycle", [round(time_s / cycle_s) for time_s in times])
    return _rows(FastSample, values)


def _frame_samples(table: CsvTable, cycle_s: float, notes: list[str]) -> list[FrameSample]:
    values = _values(table, FrameSample)
    received = _times(table, values, "received_s", notes)
    count = len(received)
    values["time_s"] = received
    _fill(values, "cycle", [round(time_s / cycle_s) for time_s in received])
    started = values.setdefault("started_s", [float("nan")] * count)
    for row, time_s in enumerate(started):
        if abs(time_s) > _MAX_TIME_S:
            raise table.error(row, "started_s", f"a time in seconds of at most {_MAX_TIME_S:g} is needed")
    _fill(values, "started_cycle", [UNCOUNTED if isnan(t) else round(t / cycle_s) for t in started])
    displacement = values.setdefault("displacement_px", [float("nan")] * count)
    _fill(values, "status", [int(status_of(value)) for value in displacement])
    for row, status in enumerate(values["status"]):
        if status not in TrackingStatus.__members__.values():
            raise table.error(row, "status", f"a tracking status from 0 to {max(TrackingStatus)} is needed")
    if "frame" not in table.columns:
        notes.append("frames.csv: no column frame; rows are counted instead")
        values["frame"] = list(range(count))
    return _rows(FrameSample, values)


def status_of(displacement_px: float) -> TrackingStatus:
    """The status of a frame that was recorded without one."""
    return TrackingStatus.NO_IMAGE if isnan(displacement_px) else TrackingStatus.MEASURED


def _fill(values: dict[str, list[Any]], name: str, derived: list[int]) -> None:
    """Take what is derived for a column that is absent, or for its empty fields."""
    given = values.get(name)
    if given is None:
        values[name] = derived
    else:
        values[name] = [d if g == UNCOUNTED else g for g, d in zip(given, derived, strict=True)]


def _rows(kind: type[Any], values: dict[str, list[Any]]) -> list[Any]:
    names = list(values)
    return [kind(**dict(zip(names, row, strict=True))) for row in zip(*values.values(), strict=True)]


def _with_foreign(
    topic: str, rows: list[Any], table: CsvTable | None
) -> Iterator[tuple[float, list[tuple[str, msgspec.Struct]]]]:
    """Each row's time and messages: its own, and the unknown columns' where there are any."""
    unknown = _unknown(table, type(rows[0])) if table and rows else []
    columns = [numbers_or_texts(table.columns[name]) for name in unknown] if table else []
    for index, row in enumerate(rows):
        found: list[tuple[str, msgspec.Struct]] = [(topic, row)]
        if unknown:
            held = {name: column[index] for name, column in zip(unknown, columns, strict=True)}
            found.append((f"{topic}/columns", ForeignColumns(row.time_s, held)))
        yield row.time_s, found
