"""`stillarm export REC`: a recording's topics as CSV files (fast.csv and frames.csv as the bundle has them)
or Parquet.

A column without information is left out: one that was never measured, or that follows from the others.
"""

import csv
import importlib
from collections.abc import Callable
from math import isnan
from pathlib import Path
from typing import Any

from stillarm.common.csv_bundle.bundle_import import UNCOUNTED, known_columns, status_of
from stillarm.common.files.model import Model
from stillarm.common.files.typed_toml import parse_toml
from stillarm.common.recording.header import model_was_given
from stillarm.common.recording.reader import Recording
from stillarm.common.recording.topics import TOPICS, FastSample, FrameSample, ImageSample, Topic
from stillarm.common.user_error import UserError, reason_of

Table = dict[str, list[Any]]  # columns of one length by name; None where there is no value


def export_csv(recording: Recording, directory: str | Path) -> list[Path]:
    """Write each topic as a CSV file, and model.toml if the recording holds one; returns the files.

    Importing what was exported gives the same samples; exporting an import gives the same values. Raises
    UserError.
    """

    def write(path: Path, table: Table) -> None:
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(table)
            writer.writerows(zip(*(map(_field, column) for column in table.values()), strict=True))

    return _export(recording, Path(directory), ".csv", write)


def export_parquet(recording: Recording, directory: str | Path) -> list[Path]:
    """The same as Parquet files. Raises UserError, with the remedy, when the package pyarrow is not installed."""
    try:
        arrow = importlib.import_module("pyarrow")
        parquet = importlib.import_module("pyarrow.parquet")
    except ImportError:
        raise UserError(
            "export as Parquet: needs the package pyarrow; `pip install pyarrow`, or export CSV"
        ) from None

    def write(path: Path, table: Table) -> None:
        parquet.write_table(arrow.table(table), path)

    return _export(recording, Path(directory), ".parquet", write)


def topic_tables(recording: Recording) -> dict[str, Table]:
    """Each topic's table by the stem of its file: 'fast', 'frames', 'truth_state'."""
    model = parse_toml(recording.header.model, Model, f"{recording.path}: model")
    tables: dict[str, Table] = {}
    for topic in TOPICS:
        if not recording.counts.get(topic.name) or topic.name.endswith("/columns"):
            continue
        table = _columns(recording, topic)
        if topic.message is FastSample:
            table = _fast_table(table, model.timing.cycle_s)
        elif topic.message is FrameSample:
            table = _frames_table(table, model.timing.cycle_s)
        table = _flat(table)
        if recording.counts.get(f"{topic.name}/columns"):
            table |= _foreign_table(recording, f"{topic.name}/columns")
        tables[topic.short_name] = table
    return tables


def _columns(recording: Recording, topic: Topic) -> Table:
    if topic.message is not ImageSample:
        return {name: column.tolist() for name, column in recording.columns(topic.name).items()}
    # no table of pixels
    names = [name for name in ImageSample.__struct_fields__ if name not in ("format", "data")]
    rows = [[getattr(image, name) for name in names] for image in recording.messages(topic.name)]
    return {name: list(column) for name, column in zip(names, zip(*rows, strict=True), strict=True)}


def _export(
    recording: Recording, directory: Path, suffix: str, write: Callable[[Path, Table], None]
) -> list[Path]:
    tables = topic_tables(recording)
    written = [directory / f"{stem}{suffix}" for stem in tables]
    try:
        directory.mkdir(parents=True, exist_ok=True)
        for path, table in zip(written, tables.values(), strict=True):
            write(path, table)
        if model_was_given(recording.header):
            (directory / "model.toml").write_text(recording.header.model, encoding="utf-8", newline="")
            written.append(directory / "model.toml")
    except OSError as error:
        raise UserError(
            f"{directory}: cannot be written ({reason_of(error)}); name a folder that you may write to"
        ) from None
    return written


def _fast_table(table: Table, cycle_s: float) -> Table:
    derived = [round(time_s / cycle_s) for time_s in table["time_s"]]
    left_out = {"cycle"} if table["cycle"] == derived else set()
    if not any(table["damping_allowed"]):
        left_out.add("damping_allowed")
    return _pick(table, FastSample, left_out | _unmeasured(table))


def _frames_table(table: Table, cycle_s: float) -> Table:
    started = [UNCOUNTED if isnan(time_s) else round(time_s / cycle_s) for time_s in table["started_s"]]
    derived = {
        "cycle": [round(time_s / cycle_s) for time_s in table["received_s"]],
        "started_cycle": started,
        "status": [int(status_of(value)) for value in table["displacement_px"]],
        "features": [0] * len(started),
        "inliers": [0] * len(started),
        "restarted": [False] * len(started),
    }
    left_out = {name for name, values in derived.items() if table[name] == values}
    table["frame"] = [None if frame == UNCOUNTED else frame for frame in table["frame"]]
    return _pick(table, FrameSample, left_out | _unmeasured(table))


def _unmeasured(table: Table) -> set[str]:
    return {name for name, values in table.items() if all(map(_absent, values))}


def _absent(value: Any) -> bool:
    return isinstance(value, float) and isnan(value)


def _pick(table: Table, kind: type[Any], left_out: set[str]) -> Table:
    """The columns of a bundle's file, those that outside scripts know first."""
    order = known_columns(kind)
    if kind is FrameSample:
        order.sort(
            key=lambda name: _FRAMES_FIRST.index(name) if name in _FRAMES_FIRST else len(_FRAMES_FIRST)
        )
    return {name: table[name] for name in order if name not in left_out}


_FRAMES_FIRST = [
    "frame",
    "received_s",
    "started_s",
    "displacement_px",
    "captured_s",
    "exposure_s",
    "features",
    "inliers",
]


def _flat(table: Table) -> Table:
    """Lists as columns of their own: modal_deflections_m becomes modal_deflections_1_m, ..._2_m; NaN becomes None."""
    flat: Table = {}
    for name, values in table.items():
        if values and isinstance(values[0], list):
            stem, _, unit = name.rpartition("_")
            for index in range(len(values[0])):
                flat[f"{stem}_{index + 1}_{unit}"] = [
                    None if v[index] != v[index] else v[index] for v in values
                ]
        else:
            flat[name] = [None if _absent(value) else value for value in values]
    return flat


def _foreign_table(recording: Recording, topic: str) -> Table:
    rows = recording.columns(topic)["columns"].tolist()
    names = list(dict.fromkeys(name for row in rows for name in row))
    return {name: [row.get(name) for row in rows] for name in names}


def _field(value: Any) -> str:
    """The shortest text that reads back as the same value."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(int(value))
    return value if isinstance(value, str) else repr(value)
