"""A recording written by the second process is the one that a writer in this process makes, to the byte."""

from pathlib import Path

import pytest

from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recording.topics import LogLine, TrueFrame
from stillarm.common.recording.writer import RecordingWriter
from stillarm.common.user_error import UserError
from stillarm.simulation.recording.recording_process import RecordingProcess

pytestmark = pytest.mark.slow

HEADER = RecordingHeader(
    program_version="1", configuration="", configuration_name="x", model="", method="", kind="simulated"
)


def test_the_same_bytes_as_without_it(tmp_path: Path) -> None:
    """Two files at once, more messages than a batch holds."""
    messages = [TrueFrame(k / 65, k, k / 65 - 0.07, k / 65) for k in range(5000)]
    log = [LogLine(1.0, "info", "strike")]
    files = RecordingProcess([(tmp_path / "a.mcap", HEADER), (tmp_path / "b.mcap", HEADER)])
    first, second = files.sinks
    for message in messages:
        first.write("/truth/frames", message)
    second.write("/log", log[0])
    files.close()
    files.close()
    for name, topic, wanted in (("a", "/truth/frames", messages), ("b", "/log", log)):
        writer = RecordingWriter(tmp_path / f"{name}_direct.mcap", HEADER)
        for message in wanted:
            writer.write(topic, message)
        writer.close()
        assert (tmp_path / f"{name}.mcap").read_bytes() == (tmp_path / f"{name}_direct.mcap").read_bytes()


def test_a_file_that_cannot_be_written_is_one_line_and_no_hang(tmp_path: Path) -> None:
    """The error appears at the latest on closing, however much was written before."""
    files = RecordingProcess([(tmp_path / "absent" / "a.mcap", HEADER)])
    (sink,) = files.sinks
    with pytest.raises(UserError) as error:
        for k in range(20_000):
            sink.write("/truth/frames", TrueFrame(0.0, k, 0.0, 0.0))
        files.close()
    assert "a.mcap" in str(error.value)
    assert "\n" not in str(error.value)


def test_a_simulation_is_stopped_soon_after_a_file_could_not_be_begun(tmp_path: Path) -> None:
    """It does not go on to its end in order to learn that it was for nothing."""
    files = RecordingProcess([(tmp_path / "absent" / "a.mcap", HEADER)])
    (sink,) = files.sinks
    assert files._connection.poll(30.0)  # the failure has arrived
    with pytest.raises(UserError, match=r"a\.mcap"):
        for k in range(5000):
            sink.write("/truth/frames", TrueFrame(0.0, k, 0.0, 0.0))
    files.close()


def test_a_process_that_died_is_one_line_that_says_how(tmp_path: Path) -> None:
    """Once: closed again, nothing is left to say."""
    files = RecordingProcess([(tmp_path / "a.mcap", HEADER)])
    files._process.kill()
    with pytest.raises(UserError, match=r"the recording's process died \(exit status -9\)"):
        files.close()
    files.close()
