"""`stillarm diagnose A B` of one driven rig: one answer for the rig, a view of each, and a bad file stops no other."""

import json
from pathlib import Path

import pytest

from stillarm.commands.recordings import diagnose_many
from stillarm.main import main
from tests.fixtures.current_joint import write_recording
from tests.stillarm.commands.recordings.test_diagnose_many import threads


@pytest.mark.slow
def test_two_of_one_rig_have_one_answer_and_a_bad_file_stops_neither(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(diagnose_many, "executor_for", threads)
    bad = tmp_path / "bad.mcap"
    bad.write_bytes(b"no recording")
    names = [str(write_recording(tmp_path / f"{k}.mcap", 3.0, seed=30 + k)) for k in range(2)]
    out = tmp_path / "out"
    told = ["--budget-s", "600"]  # what a busy machine does not get to is not judged here
    assert main(["diagnose", names[0], str(bad), names[1], "--out", str(out), *told]) == 1
    said = capsys.readouterr()
    assert [line for line in said.err.splitlines() if "bad.mcap" in line]
    assert "2 recordings of one rig: joint_coulomb_friction" in said.out
    rig = json.loads((out / "diagnosis.json").read_text())
    assert rig["findings"][0]["holds_in"] == ["0", "1"]
    assert [row["recording"] for row in rig["recordings"]] == ["0", "1"]
    assert "<h2>Recordings</h2>" in (out / "report.html").read_text() and not (out / "bad").exists()
    for name in ("0", "1"):
        assert json.loads((out / name / "diagnosis.json").read_text())["rig"] == "../diagnosis.json"
