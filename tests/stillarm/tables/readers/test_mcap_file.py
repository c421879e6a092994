"""MCAP: nested messages, several topics, encodings that are not read."""

import json
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer

from stillarm.common.user_error import UserError
from stillarm.tables.readers.flat_message import flat
from stillarm.tables.readers.mcap_file import read
from stillarm.tables.readers.ros2_messages import cdr_decoder


def written(path: Path, topics: dict[str, tuple[str, list[bytes]]]) -> Path:
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        for topic, (encoding, messages) in topics.items():
            schema = writer.register_schema("any", "jsonschema", b"{}")
            channel = writer.register_channel(topic, encoding, schema)
            for index, data in enumerate(messages):
                writer.add_message(channel, 1_000_000 * index, data, 1_000_000 * index)
        writer.finish()
    return path


def test_topics_are_tables_and_what_is_not_read_is_named(tmp_path: Path) -> None:
    rows = [
        json.dumps({"imu": {"acc": [1.5 * i, -2.0]}, "name": "x", "gap": None if i == 2 else i}).encode()
        for i in range(5)
    ]
    other = [json.dumps({"stamp": {"sec": 7, "nsec": 5 + i}}).encode() for i in range(3)]
    file = read(
        written(
            tmp_path / "a.mcap",
            {"/a": ("json", rows), "/b": ("json", other), "/c": ("protobuf", [b"\x08\x01"])},
        )
    )
    first, second = file.tables
    assert first.columns["imu.acc[0]"].tolist() == [0.0, 1.5, 3.0, 4.5, 6.0]
    assert np.isnan(first.columns["gap"][2]) and first.columns["log_time_ns"][4] == 4_000_000
    assert second.columns["stamp_ns"].tolist() == [7_000_000_005, 7_000_000_006, 7_000_000_007]
    assert any("/c: message encoding 'protobuf' is not read" in note for note in file.notes)


def test_nothing_readable_is_refused_with_the_reason(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="'protobuf' is not read"):
        read(written(tmp_path / "a.mcap", {"/c": ("protobuf", [b"\x08\x01"])}))


def test_a_damaged_message_is_left_out_and_said(tmp_path: Path) -> None:
    file = read(written(tmp_path / "a.mcap", {"/a": ("json", [b'{"x": 1}', b"{", b'{"x": 2}'])}))
    assert (
        file.tables[0].columns["x"].tolist() == [1, 2] and "1 messages could not be decoded" in file.notes[0]
    )


def test_flat_messages() -> None:
    message = {
        "name": ["a", "b"],
        "position": [1.0, 2.0],
        "velocity": [],
        "deep": {"ok": True},
        "image": [0] * 99,
    }
    assert flat(message) == {"position.a": 1.0, "position.b": 2.0, "deep.ok": 1}


def test_a_definition_that_is_none_is_told() -> None:
    decode, problem = cdr_decoder("a/msg/B", "ros2msg", b"\xff not a definition {")
    assert decode is None and "a/msg/B" in problem
    assert cdr_decoder("a/msg/B", "omgidl", b"")[0] is None
