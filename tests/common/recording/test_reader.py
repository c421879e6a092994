"""Whole, cut and damaged recordings give what is whole in them, or one line."""

import io
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import Writer

from stillarm.common.recording.reader import open_recording
from stillarm.common.recording.topics import EstimateSample, LogLine, TrueState
from stillarm.common.user_error import UserError
from tests.fixtures.recordings import some_fast, written


def test_lists_of_floats_make_a_table_and_null_is_nan(tmp_path: Path) -> None:
    states = [TrueState(0.0, 1, 2, 3, 4, 5, 6, [1.5, math.nan]), TrueState(1.0, 1, 2, 3, 4, 5, 6, [2.5])]
    path = tmp_path / "t.mcap"
    path.write_bytes(written([("/truth/state", s) for s in states]))
    recording = open_recording(path)
    table = recording.columns("/truth/state")["modal_deflections_m"]
    np.testing.assert_array_equal(table, [[1.5, math.nan], [2.5, math.nan]])
    assert math.isnan(next(recording.messages("/truth/state")).modal_deflections_m[1])


def test_a_field_without_default_may_be_null(tmp_path: Path) -> None:
    path = tmp_path / "e.mcap"
    sample = EstimateSample(0.0, 0, math.nan, math.nan, "held", math.nan, math.nan, math.nan, 0.0, "off")
    path.write_bytes(written([("/estimate", sample)]))
    assert math.isnan(next(open_recording(path).messages("/estimate")).delay_s)


@pytest.mark.slow
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_a_cut_file_gives_a_prefix(tmp_path: Path, data: st.DataObject) -> None:
    messages = some_fast(3000)
    whole = written(messages)
    path = tmp_path / "cut.mcap"
    length = data.draw(st.integers(0, len(whole) - 1))
    path.write_bytes(whole[:length])
    try:
        recording = open_recording(path)
    except UserError as error:
        assert length < whole.index(b"stillarm.notes") and "\n" not in str(error)
        return
    assert recording.cut
    if recording.counts.get("/fast"):
        got = list(recording.messages("/fast"))
        assert [repr(m) for m in got] == [repr(m) for _, m in messages[: len(got)]]


def test_what_could_not_be_read_is_told_in_words(tmp_path: Path) -> None:
    whole = written(some_fast(3000))
    path = tmp_path / "recording.mcap"
    path.write_bytes(whole)
    assert open_recording(path).incomplete == ""
    path.write_bytes(whole[: len(whole) // 2])
    assert open_recording(path).incomplete == "its end is missing"


def test_a_cut_loses_at_most_the_last_second_before_it(tmp_path: Path) -> None:
    whole = written(some_fast(5000))
    summary = make_reader(io.BytesIO(whole)).get_summary()
    assert summary is not None
    third = summary.chunk_indexes[3]
    path = tmp_path / "cut.mcap"
    path.write_bytes(whole[: third.chunk_start_offset + third.chunk_length - 5])
    assert open_recording(path).counts["/fast"] >= 1500


def foreign(
    path: Path, payload: bytes, *, encoding: str = "json", version: str = "1", header: bool = True
) -> None:
    """A file of another writer, with unchunked messages."""
    with path.open("wb") as file:
        writer = Writer(file, use_chunking=False)
        writer.start()
        if header:
            fields = {
                "format": version,
                "program_version": "9",
                "method": "m",
                "kind": "live",
                "seed": "null",
            }
            fields |= {"configuration": "", "configuration_name": "", "model": "", "new_key": "x"}
            writer.add_metadata("stillarm", fields)
        schema = writer.register_schema("s", "jsonschema", b"{}")
        channel = writer.register_channel("/log", encoding, schema)
        writer.add_message(channel, 0, b'{"time_s":0,"level":"a","text":"b","more":[1]}', 0)
        writer.add_message(channel, 1, payload, 1)
        writer.finish()  # type: ignore[no-untyped-call]


def test_unknown_fields_and_header_keys_are_passed_over(tmp_path: Path) -> None:
    path = tmp_path / "f.mcap"
    foreign(path, b'{"time_s":null,"level":"c","text":"d"}')
    lines = list(open_recording(path).messages("/log"))
    assert lines[0] == LogLine(0.0, "a", "b")
    assert math.isnan(lines[1].time_s) and open_recording(path).header.seed is None


@pytest.mark.parametrize(
    ("payload", "options", "expected"),
    [
        (b'{"time_s":"x","level":"c","text":"d"}', {}, "/log message 1 "),
        (b'{"level":"c","text":"d"}', {}, "/log message 1 "),
        (b'{"time_s":0,"level":"a","text":"b"},{"time_s":0,"level":"a","text":"b"}', {}, "/log message 1 "),
        (b"{}", {"encoding": "cdr"}, "'cdr'"),
        (b"{}", {"version": "2"}, "format '2'"),
        (b"{}", {"header": False}, "another program"),
    ],
)
def test_foreign_files_are_refused_in_one_line(
    tmp_path: Path, payload: bytes, options: dict[str, object], expected: str
) -> None:
    path = tmp_path / "f.mcap"
    foreign(path, payload, **options)  # type: ignore[arg-type]
    for read in (lambda r: list(r.messages("/log")), lambda r: r.columns("/log")):
        with pytest.raises(UserError) as refused:
            read(open_recording(path))
        assert expected in str(refused.value) and "\n" not in str(refused.value)


def test_a_topic_that_is_not_there_is_named_with_those_that_are(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(written(some_fast(1)))
    with pytest.raises(UserError, match="/frames; it holds /fast"):
        open_recording(path).messages("/frames")
    with pytest.raises(UserError, match="no such file"):
        open_recording(tmp_path / "none.mcap")
