"""A recording as files: what was imported comes out again, and a folder that cannot be written is named."""

import csv
import importlib
import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from stillarm.common.csv_bundle.bundle_export import export_csv, export_parquet
from stillarm.common.csv_bundle.bundle_import import import_bundle
from stillarm.common.files.model import load_model
from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recording.reader import open_recording
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
from tests.fixtures.bundles import imported, numbers, tables

REUSED = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


texts = st.text(
    st.characters(min_codepoint=32, max_codepoint=0x2FF, exclude_characters="\x7f\x85"), max_size=6
).filter(lambda text: not text.lstrip().startswith("#"))  # in a row's first field it makes the row a comment


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


def test_parquet_needs_its_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    recording = imported(tmp_path, "time_s,deflection_m\n0,\n1,2.5\n")
    real = importlib.import_module

    def without(name: str, *rest: object) -> object:
        if name.startswith("pyarrow"):
            raise ImportError(name)
        return real(name)

    monkeypatch.setattr(importlib, "import_module", without)
    with pytest.raises(UserError, match="pip install pyarrow") as refused:
        export_parquet(recording, tmp_path / "out")
    assert "\n" not in str(refused.value)


def test_parquet_holds_the_columns_of_the_csv(tmp_path: Path) -> None:
    recording = imported(tmp_path, "time_s,deflection_m\n0,\n1,2.5\n")
    export_parquet(recording, tmp_path / "out")
    table = importlib.import_module("pyarrow.parquet").read_table(tmp_path / "out" / "fast.parquet")
    assert table.to_pydict() == {"time_s": [0.0, 1.0], "deflection_m": [None, 2.5], "operator": [0, 0]}


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    recording = imported(tmp_path, "time_s\n0\n")
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="file: cannot be written"):
        export_csv(recording, tmp_path / "file")
