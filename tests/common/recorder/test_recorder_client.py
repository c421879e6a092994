"""The recorder's start in two steps: loaded and warm first, its file when cycle 0 has a date."""

import os
from pathlib import Path

import msgspec
import pytest

from stillarm.common.memory.shared_memory import block_path
from stillarm.common.recorder.recorder_client import RecorderClient
from stillarm.common.recorder.warm_up import blank_message, warm_up
from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recording.reader import open_recording
from stillarm.common.recording.topics import TOPIC_INDEX, TOPICS, FastSample, TrueState
from stillarm.common.user_error import UserError

HEADER = RecordingHeader(
    program_version="0", configuration="", configuration_name="", model="", method="m", kind="live"
)


def own_rings() -> list[Path]:
    return list(block_path("x").parent.glob(f"stillarm-recorder-{os.getpid()}-*"))


@pytest.mark.slow
def test_a_launched_recorder_waits_for_its_file_and_then_records(tmp_path: Path) -> None:
    """No file is there before begin(), however long the process has been loaded."""
    client = RecorderClient.launch()
    client.wait_until_loaded()
    assert client.alive() and not list(tmp_path.iterdir())
    client.begin(tmp_path / "a.mcap", HEADER)
    client.put(TOPIC_INDEX["/fast"], FastSample(0.0, 7))
    assert client.close()
    assert [m.cycle for m in open_recording(tmp_path / "a.mcap").messages("/fast")] == [7]


@pytest.mark.slow
def test_one_that_never_began_leaves_nothing_behind() -> None:
    """As where a device refuses the start meanwhile; it is no cut recording."""
    client = RecorderClient.launch()
    assert len(own_rings()) == 1
    assert client.close() and client.close()
    assert not client.alive() and not own_rings()


@pytest.mark.slow
def test_a_file_that_cannot_be_written_is_told_at_begin(tmp_path: Path) -> None:
    """In one line, and the process is gone."""
    client = RecorderClient.launch()
    with pytest.raises(UserError, match="cannot be written") as refused:
        client.begin(tmp_path / "none" / "a.mcap", HEADER)
    assert "\n" not in str(refused.value)
    assert not client.alive()
    client.close()
    assert not own_rings()


@pytest.mark.parametrize("topic", TOPICS, ids=lambda topic: topic.name)
def test_every_topic_has_a_blank_message_that_survives_its_encoding(topic: object) -> None:
    """So that a new topic is warmed up, too."""
    kind = topic.message  # type: ignore[attr-defined]
    encoded = msgspec.msgpack.encode(blank_message(kind))
    assert msgspec.msgpack.encode(msgspec.msgpack.Decoder(kind).decode(encoded)) == encoded


def test_a_blank_message_holds_zeros_where_values_are_required() -> None:
    assert blank_message(TrueState) == TrueState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, [0.0])


def test_warming_up_touches_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    warm_up()
    assert not list(tmp_path.iterdir())
