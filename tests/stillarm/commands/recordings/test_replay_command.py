"""`stillarm replay`: files that it does not overwrite, and its messages."""

from pathlib import Path

import pytest

from stillarm.main import main
from tests.fixtures.commands import one_line


def test_a_replay_spares_the_measured_frames(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its own table has the same name as the bundle's."""
    (tmp_path / "fast.csv").write_text("time_s,acceleration_m_s2\n0.0,1.0\n0.001,1.0\n")
    (tmp_path / "frames.csv").write_text("frame,received_s\n1,0.0\n")
    assert main(["import", str(tmp_path), "-o", str(tmp_path / "rec.mcap")]) == 0
    capsys.readouterr()
    assert main(["replay", str(tmp_path / "rec.mcap"), "--out", str(tmp_path)]) == 1
    assert "CSV bundle" in one_line(capsys)
    assert (tmp_path / "frames.csv").read_text() == "frame,received_s\n1,0.0\n"


def test_a_replay_tells_that_its_recording_was_cut(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """Otherwise the missing part would look like an error of the replay."""
    (tmp_path / "model.toml").write_text("[arm]\nlength_m = 2.0\n")
    (tmp_path / "fast.csv").write_text("time_s\n" + "".join(f"{n / 1000}\n" for n in range(2000)))
    whole, cut = tmp_path / "whole.mcap", tmp_path / "cut.mcap"
    assert main(["import", str(tmp_path), "-o", str(whole)]) == 0
    content = whole.read_bytes()
    cut.write_bytes(content[: len(content) // 2])
    capsys.readouterr()
    assert main(["replay", str(whole), "--out", str(tmp_path / "a")]) == 0
    assert "missing" not in capsys.readouterr().out
    assert main(["replay", str(cut), "--out", str(tmp_path / "b")]) == 0
    assert "its end is missing" in capsys.readouterr().out
