"""What is written is read back, exactly; by the public reader too; and a damaged file gives what is whole."""

import io
import json
import math
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import Writer

from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recording.json_schema import json_schema
from stillarm.common.recording.reader import open_recording
from stillarm.common.recording.topics import TOPICS, EstimateSample, FastSample, LogLine, TrueState
from stillarm.common.recording.writer import RecordingWriter
from stillarm.common.user_error import UserError

HEADER = RecordingHeader(
    program_version="0.1.0",
    configuration='model = "m.toml"\n# Größe\n',
    configuration_name="x.toml",
    model="[arm]\nlength_m = 2.0\n",
    method="correlation",
    kind="simulated",
    session=2**62 + 1,
    origin_monotonic_s=1234.000000001,
    origin_unix_ns=1_700_000_000_000_000_123,
    seed=7,
    notes={"b": "2", "a": "1"},
)
any_float = st.floats(allow_nan=True, allow_infinity=True)
any_time = st.floats(-1e6, 1e6)
fast_samples = st.builds(FastSample, any_time, st.integers(-(2**62), 2**62), any_float, any_float)
log_lines = st.builds(LogLine, any_time, st.text(max_size=5), st.text(max_size=40))


def written(messages: list[tuple[str, msgspec.Struct]], header: RecordingHeader = HEADER) -> bytes:
    file = io.BytesIO()
    writer = RecordingWriter(file, header)
    for topic, message in messages:
        writer.write(topic, message)
    writer.close()
    return file.getvalue()


def some_fast(count: int) -> list[tuple[str, msgspec.Struct]]:
    random = np.random.default_rng(0)
    return [("/fast", FastSample(i * 0.001, i, float(random.normal()))) for i in range(count)]


def finite(message: msgspec.Struct) -> dict[str, object]:
    """As a file can hold it: what is not finite is absent."""
    plain = msgspec.structs.asdict(message)
    return {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in plain.items()}


@pytest.mark.slow
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(fast_samples, min_size=1, max_size=20), st.lists(log_lines, max_size=5))
def test_messages_come_back_exactly(tmp_path: Path, fast: list[FastSample], log: list[LogLine]) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(written([*(("/fast", m) for m in fast), *(("/log", m) for m in log)]))
    recording = open_recording(path)
    assert recording.header == HEADER
    assert not recording.cut and recording.damaged == 0
    assert [finite(m) for m in recording.messages("/fast")] == [finite(m) for m in fast]
    columns = recording.columns("/fast")
    for name in FastSample.__struct_fields__:
        expected = [finite(m)[name] for m in fast]
        got = [None if isinstance(v, float) and math.isnan(v) else v for v in columns[name].tolist()]
        assert got == expected
    if log:
        assert list(recording.messages("/log")) == log


def test_the_public_reader_opens_it(tmp_path: Path) -> None:
    data = written([("/fast", FastSample(0.5, 500, math.inf)), ("/log", LogLine(0.25, "info", "hé"))])
    reader = make_reader(io.BytesIO(data))
    found = list(reader.iter_messages())
    assert [channel.topic for _, channel, _ in found] == ["/log", "/fast"]
    schema, channel, message = found[1]
    assert schema is not None and (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
    assert message.log_time == HEADER.origin_unix_ns + 500_000_000
    assert json.loads(message.data)["acceleration_m_s2"] is None
    assert json.loads(schema.data)["type"] == "object"
    names = [record.name for record in reader.iter_metadata()]
    assert names == ["stillarm", "stillarm.notes"]


def test_each_schema_names_every_field_with_one_plain_type() -> None:
    for topic in TOPICS:
        schema = json.loads(json_schema(topic.message))
        assert list(schema["properties"]) == list(topic.message.__struct_fields__)
        for kind in schema["properties"].values():  # Foxglove takes no list of types
            assert kind["type"] in {"number", "integer", "boolean", "string", "array", "object"}


def test_the_same_input_gives_the_same_bytes() -> None:
    shuffled = msgspec.structs.replace(HEADER, notes={"a": "1", "b": "2"})
    assert written(some_fast(2500)) == written(some_fast(2500), shuffled)


def test_the_header_stands_before_the_messages() -> None:
    data = written(some_fast(10))
    assert 0 < data.index(b"length_m = 2.0") < 2000


def test_chunks_span_less_than_a_second(tmp_path: Path) -> None:
    data = written(some_fast(3000))
    summary = make_reader(io.BytesIO(data)).get_summary()
    assert summary is not None
    spans = [c.message_end_time - c.message_start_time for c in summary.chunk_indexes]
    assert len(spans) >= 5 and max(spans) < 1e9


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


def test_a_cut_loses_at_most_the_last_second_before_it(tmp_path: Path) -> None:
    whole = written(some_fast(5000))
    summary = make_reader(io.BytesIO(whole)).get_summary()
    assert summary is not None
    third = summary.chunk_indexes[3]
    path = tmp_path / "cut.mcap"
    path.write_bytes(whole[: third.chunk_start_offset + third.chunk_length - 5])
    assert open_recording(path).counts["/fast"] >= 1500


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_damage_gives_messages_or_one_line(tmp_path: Path, data: st.DataObject) -> None:
    damaged = bytearray(_SMALL)
    for _ in range(data.draw(st.integers(1, 6))):
        place = data.draw(st.integers(0, len(damaged) - 1))
        damaged[place] = data.draw(st.integers(0, 255))
    path = tmp_path / "damaged.mcap"
    path.write_bytes(damaged)
    try:
        recording = open_recording(path)
        for topic in [t for t, n in recording.counts.items() if n]:
            rows = list(recording.messages(topic))
            assert len(recording.columns(topic)["time_s"]) == len(rows) == recording.counts[topic]
    except UserError as error:
        assert "\n" not in str(error)


_SMALL = written([*some_fast(3), ("/log", LogLine(0.0, "info", "text"))])


@settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.binary(max_size=300))
def test_any_bytes_are_refused_in_one_line(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "any.mcap"
    for content in (data, _SMALL[:8] + data):
        path.write_bytes(content)
        with pytest.raises(UserError) as refused:
            open_recording(path)
        assert "\n" not in str(refused.value)


def test_a_damaged_chunk_costs_itself_only(tmp_path: Path) -> None:
    whole = bytearray(written(some_fast(3000)))
    summary = make_reader(io.BytesIO(bytes(whole))).get_summary()
    assert summary is not None
    first = summary.chunk_indexes[0]  # the one that holds the schema and the channel
    middle = first.chunk_start_offset + first.chunk_length // 2
    whole[middle : middle + 4] = b"\xff\x00\xff\x00"
    path = tmp_path / "damaged.mcap"
    path.write_bytes(whole)
    recording = open_recording(path)
    assert recording.damaged == 1 and not recording.cut
    assert [m.cycle for m in recording.messages("/fast")] == list(range(500, 3000))


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


class FullDisk(io.BytesIO):
    """A file on a disk with room for so many bytes; a write may be partial, as an operating system's."""

    def __init__(self, room: int) -> None:
        super().__init__()
        self.room = room

    def write(self, data: object) -> int:
        part = bytes(memoryview(data))[: self.room - self.tell()]  # type: ignore[arg-type]
        if not part:
            raise OSError(28, "No space left on device")
        return super().write(part)


@pytest.mark.slow
@pytest.mark.parametrize("room", range(1500, 160_000, 9973))
def test_a_full_disk_leaves_a_file_that_opens(tmp_path: Path, room: int) -> None:
    disk = FullDisk(room)
    with pytest.raises(UserError, match="no space left on device") as refused:
        writer = RecordingWriter(disk, HEADER)
        for topic, message in some_fast(6000):
            writer.write(topic, message)
        writer.close()
    assert "\n" not in str(refused.value)
    path = tmp_path / "full.mcap"
    path.write_bytes(disk.getvalue())
    recording = open_recording(path)
    count = recording.counts.get("/fast", 0)
    if count:
        assert [m.cycle for m in recording.messages("/fast")] == list(range(count))
    if not recording.cut:
        assert len(list(make_reader(io.BytesIO(disk.getvalue())).iter_messages())) == count
    with pytest.raises(UserError):
        writer.write("/fast", FastSample(0.0, 0))


def test_a_file_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"none/a\.mcap: cannot be written"):
        RecordingWriter(tmp_path / "none" / "a.mcap", HEADER)


def test_times_that_no_log_time_can_hold_are_bounded() -> None:
    times = [12.0, math.nan, -5.0, math.inf, 9.1e9, 1e300]
    header = msgspec.structs.replace(HEADER, origin_unix_ns=0)
    data = written([("/log", LogLine(t, "", "")) for t in times], header)
    stamps = [m.log_time for _, _, m in make_reader(io.BytesIO(data)).iter_messages()]
    assert sorted(stamps) == [0, 0, 12 * 10**9, 12 * 10**9, 91 * 10**17, 91 * 10**17]
