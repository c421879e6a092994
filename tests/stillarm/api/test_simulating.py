"""`stillarm.simulate`: the command's own bytes, from a file or from a model in memory."""

from pathlib import Path

import pytest

import stillarm
from stillarm.main import main
from tests.fixtures.imports import ROOT

pytestmark = pytest.mark.slow
MODEL = ROOT / "configs" / "model.toml"


def test_the_same_bytes_as_the_commands(short_recording: Path, tmp_path: Path) -> None:
    scenario = short_recording.with_name("short.toml")
    words = ["simulate", "--model", str(MODEL), "--scenario", str(scenario), "--seed", "1"]
    assert main([*words, "-o", str(tmp_path / "rec.mcap")]) == 0
    assert (tmp_path / "rec.mcap").read_bytes() == short_recording.read_bytes()


def test_a_model_in_memory_moves_as_its_file_does(short_recording: Path, tmp_path: Path) -> None:
    scenario = short_recording.with_name("short.toml")
    made = stillarm.simulate(stillarm.Model.read(MODEL), scenario, 1, out=tmp_path / "new")
    before = stillarm.load(short_recording)
    assert (made.recording.fast["acceleration_m_s2"] == before.fast["acceleration_m_s2"]).all()
    assert made.truth["truth_state"].rows > 1000


def test_a_mistake_is_the_commands_one_line(tmp_path: Path) -> None:
    with pytest.raises(stillarm.UserError, match="demo") as error:
        stillarm.simulate(MODEL, "dmeo", out=tmp_path)
    assert "\n" not in str(error.value)
