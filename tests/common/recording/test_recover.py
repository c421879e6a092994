"""A cut recording becomes a complete one with everything that was whole."""

import io
from pathlib import Path

import pytest
from mcap.reader import make_reader

from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recording.reader import open_recording
from stillarm.common.recording.recover import recover
from stillarm.common.recording.topics import FastSample, ForeignColumns, LogLine
from stillarm.common.recording.writer import RecordingWriter
from stillarm.common.user_error import UserError

HEADER = RecordingHeader(
    program_version="0",
    configuration="",
    configuration_name="",
    model="",
    method="m",
    kind="live",
    notes={"a": "b"},
)


def cut_recording(path: Path, keep: float) -> None:
    file = io.BytesIO()
    writer = RecordingWriter(file, HEADER)
    for i in range(3000):
        writer.write("/fast", FastSample(i * 0.001, i, i / 7))
        if i % 500 == 0:
            writer.write("/log", LogLine(i * 0.001, "info", str(i)))
            writer.write("/fast/columns", ForeignColumns(i * 0.001, {"x": None, "y": "text"}))
    writer.close()
    whole = file.getvalue()
    path.write_bytes(whole[: int(len(whole) * keep)])


@pytest.mark.slow
@pytest.mark.parametrize("keep", [0.3, 0.6, 0.8, 1.0])
def test_everything_whole_is_kept(tmp_path: Path, keep: float) -> None:
    cut, mended = tmp_path / "cut.mcap", tmp_path / "mended.mcap"
    cut_recording(cut, keep)
    before = open_recording(cut)
    report = recover(cut, mended)
    after = open_recording(mended)
    assert report.cut == before.cut == (keep < 1.0)
    assert not after.cut and after.header == HEADER
    assert report.messages == after.counts == before.counts and report.messages["/fast"] > 500
    for topic in before.counts:
        assert [repr(m) for m in after.messages(topic)] == [repr(m) for m in before.messages(topic)]
    with mended.open("rb") as file:
        assert len(list(make_reader(file).iter_messages())) == sum(after.counts.values())


def test_what_cannot_be_mended_is_refused(tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    cut_recording(cut, 0.5)
    with pytest.raises(UserError, match="name another file"):
        recover(cut, cut)
    cut.write_bytes(cut.read_bytes()[:60])
    with pytest.raises(UserError, match="cut before its header"):
        recover(cut, tmp_path / "mended.mcap")
    assert not (tmp_path / "mended.mcap").exists()
