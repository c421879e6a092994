"""What is written is read back, exactly; by the public reader too; and a damaged file gives what is whole."""

import io
import json
import math
from pathlib import Path

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

from stillarm.common.recording.reader import open_recording
from stillarm.common.recording.topics import FastSample, LogLine
from stillarm.common.recording.writer import RecordingWriter
from stillarm.common.user_error import UserError
from tests.fixtures.recordings import HEADER, some_fast, written

any_float = st.floats(allow_nan=True, allow_infinity=True)
any_time = st.floats(-1e6, 1e6)
fast_samples = st.builds(FastSample, any_time, st.integers(-(2**62), 2**62), any_float, any_float)
log_lines = st.builds(LogLine, any_time, st.text(max_size=5), st.text(max_size=40))


def finite(message: msgspec.Struct) -> dict[str, object]:
    """As a file holds it: values that are not finite are absent."""
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


def test_the_same_input_gives_the_same_bytes() -> None:
    shuffled = msgspec.structs.replace(HEADER, notes={"a": "1", "b": "2"})
    assert written(some_fast(2500)) == written(some_fast(2500), shuffled)


def test_chunks_span_less_than_a_second(tmp_path: Path) -> None:
    data = written(some_fast(3000))
    summary = make_reader(io.BytesIO(data)).get_summary()
    assert summary is not None
    spans = [c.message_end_time - c.message_start_time for c in summary.chunk_indexes]
    assert len(spans) >= 5 and max(spans) < 1e9


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
