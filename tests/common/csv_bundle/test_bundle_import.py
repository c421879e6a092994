"""The CSV bundle in and out: values exactly, harmless variations read, errors in one line with the place."""

import math
from pathlib import Path

import pytest

from stillarm.common.csv_bundle.bundle_export import topic_tables
from stillarm.common.csv_bundle.bundle_import import import_bundle
from stillarm.common.datagrams.visual_sample import TrackingStatus
from stillarm.common.files.model import Model
from stillarm.common.files.typed_toml import parse_toml
from stillarm.common.recording.reader import open_recording
from stillarm.common.user_error import UserError
from tests.fixtures.bundles import bundle, imported


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
