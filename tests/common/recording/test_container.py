"""Damaged files: any bytes give messages or one line."""

import io
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

from stillarm.common.recording.reader import open_recording
from stillarm.common.recording.topics import LogLine
from stillarm.common.user_error import UserError
from tests.fixtures.recordings import some_fast, written


@pytest.mark.slow
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
