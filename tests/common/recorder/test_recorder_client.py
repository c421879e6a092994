"""The recorder's start in two steps: loaded and warm first, its file when cycle 0 has a date."""

import os
from pathlib import Path

import pytest

from stillarm.common.memory.shared_memory import block_path
from stillarm.common.recorder.recorder_client import RecorderClient
from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recording.reader import open_recording
from stillarm.common.recording.topics import TOPIC_INDEX, FastSample
from stillarm.common.user_error import UserError

HEADER = RecordingHeader(
    program_version="0", configuration="", configuration_name="", model="", method="m", kind="live"
)


def own_rings() -> list[Path]:
    return list(block_path("x").parent.glob(f"stillarm-recorder-{os.getpid()}-*"))


@pytest.mark.slow
def test_a_launched_recorder_waits_for_its_file_and_then_records(tmp_path: Path) -> None:
    """No file exists before begin(), however long ago the process was loaded."""
    client = RecorderClient.launch()
    client.wait_until_loaded()
    assert client.alive() and not list(tmp_path.iterdir())
    client.begin(tmp_path / "a.mcap", HEADER)
    client.put(TOPIC_INDEX["/fast"], FastSample(0.0, 7))
    assert client.close()
    assert [m.cycle for m in open_recording(tmp_path / "a.mcap").messages("/fast")] == [7]


@pytest.mark.slow
def test_one_that_never_began_leaves_nothing_behind() -> None:
    """For example, because a device refuses to start. This is not a cut recording."""
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
