"""The hidden world's driven cases, handed to the diagnosis as a user would hand them over."""

import json
from pathlib import Path

import pytest

from stillarm.benchmarks.diagnosis.driven import answer, model_of_stated
from stillarm.common.files.model import load_model
from tests.hidden_world.driven.case import make
from tests.hidden_world.driven.draw import draw_rig
from tests.hidden_world.driven.files import nominal, write_case


def test_a_stated_rig_is_a_model_file(tmp_path: Path) -> None:
    for seed in range(6):
        rig, _ = draw_rig(seed, "none", longest_s=5.0)
        file = tmp_path / f"{seed}.toml"
        file.write_text(model_of_stated(json.loads(json.dumps(nominal(rig)))))
        model = load_model(file)
        assert model.drive.kind == rig.drive.kind
        assert model.drive.inertia_kg_m2 == pytest.approx(rig.inertia)
        stated = [one.frequency_hz for one in model.arm.modes][: rig.arm.modes]
        assert stated == pytest.approx([one["frequency_hz"] for one in rig.arm.clamped_modes()])


@pytest.mark.slow
def test_a_case_is_answered(tmp_path: Path) -> None:
    write_case(make(21, "none", longest_s=10.0), tmp_path / "case_0001")
    (tmp_path / "answer").mkdir()
    assert answer(tmp_path / "case_0001", tmp_path / "answer", 3.0)  # whatever the verdict, and however sure
    assert json.loads((tmp_path / "answer" / "diagnosis.json").read_text())["verdict"]
