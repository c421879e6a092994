"""The CSV bundle in and out: values exactly, harmless variations read, errors in one line with the place."""

import csv
import importlib
import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from stillarm.common.csv_bundle.bundle_export import export_csv, export_parquet, topic_tables
from stillarm.common.csv_bundle.bundle_import import import_bundle
from stillarm.common.datagrams.visual_sample import TrackingStatus
from stillarm.common.files.model import Model, load_model
from stillarm.common.files.typed_toml import parse_toml
from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recording.reader import Recording, open_recording
from stillarm.common.recording.topics import (
    EstimateSample,
    FastSample,
    FrameSample,
    ImageSample,
    LogLine,
    TrueState,
)
from stillarm.common.recording.writer import RecordingWriter
from stillarm.common.user_error import UserError

REUSED = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def bundle(folder: Path, fast: str | bytes, frames: str | None = None, model: str | None = None) -> Path:
    folder.mkdir(exist_ok=True)
    for name, content in (("fast.csv", fast), ("frames.csv", frames), ("model.toml", model)):
        (folder / name).unlink(missing_ok=True)
        if content is not None:
            (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    return folder


def imported(
    folder: Path, fast: str | bytes, frames: str | None = None, model: str | None = None
) -> Recording:
    import_bundle(bundle(folder / "b", fast, frames, model), folder / "b.mcap")
    return open_recording(folder / "b.mcap")


def test_the_contract_columns_come_in(tmp_path: Path) -> None:
    recording = imported(
        tmp_path,
        "time_s,acceleration_m_s2,joint_position_rad\n0.0,1.5,0.1\n0.002,,-0.2\n",
        "frame,received_s,started_s,displacement_px,captured_s\n7,0.001,0.0,2.5,100.25\n9,0.002,,,\n",
        "[timing]\ncycle_s = 0.002\n",
    )
    first, second = recording.messages("/fast")
    assert (first.cycle, second.cycle) == (0, 1)
    assert first.acceleration_m_s2 == 1.5 and math.isnan(second.acceleration_m_s2)
    assert math.isnan(first.joint_velocity_rad_s)
    seen, unseen = recording.messages("/frames")
    assert (seen.frame, seen.received_s, seen.time_s, seen.captured_s) == (7, 0.001, 0.001, 100.25)
    assert (seen.cycle, seen.started_cycle, seen.status) == (0, 0, TrackingStatus.MEASURED)
    assert (unseen.started_cycle, unseen.status) == (-1, TrackingStatus.NO_IMAGE)
    assert math.isnan(unseen.displacement_px) and math.isnan(unseen.started_s)
    assert (
        recording.header.kind == "imported" and recording.header.configuration_name == "configs/default.toml"
    )
    assert parse_toml(recording.header.model, Model, "model").timing.cycle_s == 0.002


HARMLESS = {
    "byte order mark": b"\xef\xbb\xbftime_s,deflection_m\n0.5,2.5\n",
    "CRLF": b"time_s,deflection_m\r\n0.5,2.5\r\n",
    "old Mac": b"time_s,deflection_m\r0.5,2.5\r",
    "no newline at the end": b"time_s,deflection_m\n0.5,2.5",
    "quotes": b'"time_s","deflection_m"\n"0.5","2.5"\n',
    "spaces": b" time_s , deflection_m \n 0.5 ,  2.5\n",
    "spaces before quotes": b'"time_s", "deflection_m"\n"0.5", "2.5"\n',
    "comments": b'# a, "comment\ntime_s,deflection_m\n  # another\n0.5,2.5\n#\n',
    "blank lines": b"\n\ntime_s,deflection_m\n\n0.5,2.5\n   \n",
    "semicolons": b"time_s;deflection_m\n0.5;2.5\n",
    "tabs": b"time_s\tdeflection_m\n0.5\t2.5\n",
    "a separator at the end": b"time_s,deflection_m,\n0.5,2.5,\n",
    "exponents": b"time_s,deflection_m\n5e-1,+.25E1\n",
    "another order": b"deflection_m,time_s\n2.5,0.5\n",
}


@pytest.mark.parametrize("name", HARMLESS)
def test_harmless_variations_are_read(tmp_path: Path, name: str) -> None:
    (sample,) = imported(tmp_path, HARMLESS[name]).messages("/fast")
    assert (sample.time_s, sample.deflection_m, sample.cycle) == (0.5, 2.5, 500)


@pytest.mark.parametrize("text", ["", "nan", "NaN", "NA", "null", "  "])
def test_an_empty_field_is_no_measurement(tmp_path: Path, text: str) -> None:
    (sample,) = imported(tmp_path, f"time_s,deflection_m\n0.5,{text}\n").messages("/fast")
    assert math.isnan(sample.deflection_m)


WRONG: dict[str, tuple[str | bytes, str | None, list[str]]] = {
    "wild": ("time_s,deflection_m\n0,-1e200\n", None, ["fast.csv: line 2", "deflection_m", "1e+15"]),
    "word": ("# c\ntime_s,deflection_m\n0,1\n1,abc\n", None, ["fast.csv: line 4", "deflection_m", "'abc'"]),
    "decimal comma": ('time_s,deflection_m\n0,"1,5"\n', None, ["line 2", "'1,5'", "decimal point"]),
    "infinite": ("time_s,deflection_m\n0,inf\n", None, ["line 2", "'inf'", "finite"]),
    "underscore": ("time_s,deflection_m\n0,1_0\n", None, ["line 2", "'1_0'"]),
    "no time": ("time_s,deflection_m\n,1\n", None, ["line 2", "time_s", "every row"]),
    "huge time": ("time_s\n1e300\n", None, ["line 2", "time_s", "9e+09"]),
    "no time column": ("time,deflection_m\n0,1\n", None, ["fast.csv", "no column time_s", "rename time"]),
    "short row": ("time_s,deflection_m\n0,1\n1\n", None, ["line 3", "1 fields", "2"]),
    "long row": ("time_s\n0\n1,2\n", None, ["line 3", "2 fields"]),
    "twice": ("time_s,time_s\n0,1\n", None, ["two columns are named time_s"]),
    "nameless": ("time_s,,deflection_m\n0,1,2\n", None, ["column 2 has no name"]),
    "nameless at the end": ("time_s,\n0,1\n", None, ["column 2 holds '1'"]),
    "empty": ("", None, ["fast.csv", "empty"]),
    "only a head": ("time_s\n", None, ["fast.csv", "no rows"]),
    "open quote": ('time_s\n"0\n', None, ["fast.csv", "CSV"]),
    "UTF-16": ("time_s\n0\n".encode("utf-16"), None, ["fast.csv", "UTF-8"]),
    "permission": ("time_s,damping_allowed\n0,2\n", None, ["damping_allowed", "'2'", "true or false"]),
    "half a frame": ("time_s\n0\n", "frame,received_s\n1.5,0\n", ["frames.csv: line 2", "frame", "'1.5'"]),
    "digits": ("time_s\n0\n", f"frame,received_s\n{'9' * 5000},0\n", ["frames.csv: line 2", "frame"]),
    "status": ("time_s\n0\n", "status,received_s\n77,0\n", ["frames.csv: line 2", "status", "'77'"]),
    "started": ("time_s\n0\n", "started_s,received_s\n1e99,0\n", ["started_s", "'1e99'"]),
    "no received_s": ("time_s\n0\n", "frame\n1\n", ["frames.csv", "no column received_s"]),
}


@pytest.mark.parametrize("name", WRONG)
def test_errors_name_the_place_in_one_line(tmp_path: Path, name: str) -> None:
    fast, frames, expected = WRONG[name]
    with pytest.raises(UserError) as refused:
        imported(tmp_path, fast, frames)
    for part in expected:
        assert part in str(refused.value)
    assert "\n" not in str(refused.value) and len(str(refused.value)) < 400
    assert not (tmp_path / "b.mcap").exists()


def test_a_folder_without_fast_csv_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"fast\.csv: not there"):
        import_bundle(tmp_path, tmp_path / "a.mcap")
    with pytest.raises(UserError, match="no folder"):
        import_bundle(tmp_path / "none", tmp_path / "a.mcap")


def test_clock_steps_are_kept_and_reported(tmp_path: Path) -> None:
    folder = bundle(tmp_path / "b", "time_s\n0\n0.1\n0.1\n0.05\n0.2\n", "received_s\n1\n0.5\n")
    report = import_bundle(folder, tmp_path / "a.mcap")
    recording = open_recording(tmp_path / "a.mcap")
    assert recording.columns("/fast")["time_s"].tolist() == [0, 0.1, 0.1, 0.05, 0.2]
    assert recording.columns("/frames")["received_s"].tolist() == [1, 0.5]
    steps = [note for note in report.notes if "steps back" in note]
    assert len(steps) == 2
    assert "2 of 5 rows, first in line 4: 0.1 after 0.1" in steps[0]


def test_unknown_columns_are_kept_and_reported(tmp_path: Path) -> None:
    folder = bundle(
        tmp_path / "b",
        "time_s,acceleration_m_s,owner,serial\n0,1.5,Ann,007\n1,,,008\n",
        "received_s,time_s\n0.5,77.5\n",
    )
    report = import_bundle(folder, tmp_path / "a.mcap")
    assert report.unknown == [
        "fast.csv: acceleration_m_s",
        "fast.csv: owner",
        "fast.csv: serial",
        "frames.csv: time_s",
    ]
    assert any("if acceleration_m_s2 is meant, rename it" in note for note in report.notes)
    assert "fast.csv: acceleration_m_s2" in report.not_measured and not report.model_given
    recording = open_recording(tmp_path / "a.mcap")
    assert [row.columns for row in recording.messages("/fast/columns")] == [
        {"acceleration_m_s": 1.5, "owner": "Ann", "serial": "007"},
        {"acceleration_m_s": None, "owner": None, "serial": "008"},
    ]
    tables = topic_tables(recording)
    assert tables["fast"]["serial"] == ["007", "008"] and tables["frames"]["time_s"] == [77.5]
    assert any("model.toml: none given" in note for note in recording.header.notes.values())


def test_times_below_zero_and_of_the_calendar_come_in(tmp_path: Path) -> None:
    recording = imported(tmp_path, "time_s\n-1.5\n0\n1700000000.25\n")
    assert recording.columns("/fast")["time_s"].tolist() == [-1.5, 0.0, 1700000000.25]
    assert recording.header.origin_unix_ns == 2_000_000_000
    assert recording.columns("/fast")["cycle"].tolist() == [-1500, 0, 1700000000250]


numbers = st.floats(-1e12, 1e12) | st.none()
texts = st.text(
    st.characters(min_codepoint=32, max_codepoint=0x2FF, exclude_characters="\x7f\x85"), max_size=6
)


@st.composite
def tables(
    draw: Any, time_name: str, columns: list[str], extra: st.SearchStrategy[Any]
) -> dict[str, list[Any]]:
    rows = draw(st.integers(1, 8))
    names = draw(st.lists(st.sampled_from(columns), unique=True))
    table = {name: draw(st.lists(numbers, min_size=rows, max_size=rows)) for name in names}
    table[time_name] = draw(st.lists(st.floats(-1e6, 1e6), min_size=rows, max_size=rows))
    if draw(st.booleans()):
        table["foreign x"] = draw(st.lists(extra, min_size=rows, max_size=rows))
    return {name: table[name] for name in draw(st.permutations(list(table)))}


def write(path: Path, table: dict[str, list[Any]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(table)
        writer.writerows(
            zip(*(["" if v is None else v for v in column] for column in table.values()), strict=True)
        )


def read(path: Path) -> dict[str, list[str]]:
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    return {name: [row[i] for row in rows[1:]] for i, name in enumerate(rows[0])}


def same(given: list[Any], got: list[str] | None) -> bool:
    if got is None:  # left out: never measured
        return all(value in (None, "") for value in given)
    for value, text in zip(given, got, strict=True):
        if isinstance(value, float):
            if float(text) != value:
                return False
        elif (value or "").strip() != text:
            try:  # a text that happens to be a number, in a column of such
                if float(value) != float(text):
                    return False
            except ValueError:
                return False
    return True


FAST_COLUMNS = ["acceleration_m_s2", "joint_velocity_command_rad_s", "joint_torque_n_m", "deflection_m"]
FRAME_COLUMNS = ["displacement_px", "captured_s", "exposure_s", "displacement_y_px"]


@pytest.mark.slow
@REUSED
@given(tables("time_s", FAST_COLUMNS, texts | st.none()), tables("received_s", FRAME_COLUMNS, numbers))
def test_exporting_an_import_gives_the_same_values(
    tmp_path: Path, fast: dict[str, list[Any]], frames: dict[str, list[Any]]
) -> None:
    folder, out = tmp_path / "in", tmp_path / "out"
    folder.mkdir(exist_ok=True)
    write(folder / "fast.csv", fast)
    write(folder / "frames.csv", frames)
    import_bundle(folder, tmp_path / "a.mcap")
    export_csv(open_recording(tmp_path / "a.mcap"), out)
    for name, table in (("fast.csv", fast), ("frames.csv", frames)):
        back = read(out / name)
        for column, values in table.items():
            assert same(values, back.get(column)), (column, values, back.get(column))


floats = st.floats(-1e9, 1e9) | st.just(math.nan)
fast_rows = st.builds(
    FastSample, st.floats(0, 1e3), st.integers(0, 10**6), *[floats] * 8, damping_allowed=st.booleans()
)
frame_rows = st.builds(
    lambda t, *rest: FrameSample(t, rest[0], rest[1], t, *rest[2:]),
    st.floats(0, 1e3),
    st.integers(0, 10**6),
    st.integers(0, 10**6),
    floats,
    st.integers(0, 10**6),
    st.integers(0, 9),
    *[floats] * 9,
    st.integers(0, 500),
    st.integers(0, 500),
)
LIVE = RecordingHeader(
    program_version="0",
    configuration="",
    configuration_name="",
    model="[arm]\nlength_m = 1.5 # measured\n",
    method="m",
    kind="live",
)


@pytest.mark.slow
@REUSED
@given(st.lists(fast_rows, min_size=1, max_size=6), st.lists(frame_rows, min_size=1, max_size=6))
def test_importing_an_export_gives_the_same_samples(
    tmp_path: Path, fast: list[FastSample], frames: list[FrameSample]
) -> None:
    writer = RecordingWriter(tmp_path / "live.mcap", LIVE)
    for topic, rows in (("/fast", fast), ("/frames", frames)):
        for row in rows:
            writer.write(topic, row)
    writer.close()
    out = tmp_path / "out"
    files = export_csv(open_recording(tmp_path / "live.mcap"), out)
    assert [path.name for path in files] == ["fast.csv", "frames.csv", "model.toml"]
    import_bundle(out, tmp_path / "again.mcap")
    again = open_recording(tmp_path / "again.mcap")
    assert [repr(row) for row in again.messages("/fast")] == [repr(row) for row in fast]
    assert [repr(row) for row in again.messages("/frames")] == [repr(row) for row in frames]
    assert again.header.model == LIVE.model
    assert load_model(out / "model.toml").arm.length_m == 1.5


def test_other_topics_are_exported_too(tmp_path: Path) -> None:
    writer = RecordingWriter(tmp_path / "a.mcap", LIVE)
    writer.write("/truth/state", TrueState(0.0, 1, 2, 3, 4, 5, 6, [0.5, math.nan]))
    writer.write("/log", LogLine(0.0, "info", 'a "quoted", line'))
    writer.write("/estimate", EstimateSample(0.0, 0, math.nan, 0.1, "held", 1.0, 1.0, 1.0, 0.0, "off"))
    nan = math.nan
    writer.write("/images", ImageSample(0.5, 3, 7, nan, nan, 0, nan, nan, nan, 0, 0, "png", "aGk="))
    writer.close()
    export_csv(open_recording(tmp_path / "a.mcap"), tmp_path / "out")
    images = read(tmp_path / "out" / "images.csv")
    assert images["counter"] == ["3"] and images["stamp_s"] == [""] and "data" not in images
    state = read(tmp_path / "out" / "truth_state.csv")
    assert (state["modal_deflections_1_m"], state["modal_deflections_2_m"]) == (["0.5"], [""])
    assert read(tmp_path / "out" / "log.csv")["text"] == ['a "quoted", line']
    assert read(tmp_path / "out" / "estimate.csv")["delay_s"] == [""]


def test_parquet_needs_its_package(tmp_path: Path) -> None:
    recording = imported(tmp_path, "time_s,deflection_m\n0,\n1,2.5\n")
    try:
        parquet = importlib.import_module("pyarrow.parquet")
    except ImportError:
        with pytest.raises(UserError, match="pip install pyarrow") as refused:
            export_parquet(recording, tmp_path / "out")
        assert "\n" not in str(refused.value)
    else:
        export_parquet(recording, tmp_path / "out")
        table = parquet.read_table(tmp_path / "out" / "fast.parquet")
        assert table.to_pydict() == {"time_s": [0.0, 1.0], "deflection_m": [None, 2.5]}


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    recording = imported(tmp_path, "time_s\n0\n")
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="file: cannot be written"):
        export_csv(recording, tmp_path / "file")
