"""`stillarm benchmark` writes what it prints."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from stillarm.main import main
from tests.fixtures.estimator_campaign import CONTRACT, SMALL


@pytest.mark.slow
def test_the_command_writes_table_file_and_pictures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """`stillarm benchmark estimators` from end to end, cut down; mistakes in one line."""
    short = replace(SMALL, trials=1, regimes=("freerun constant",), methods=("timestamps",))
    monkeypatch.setattr("stillarm.benchmarks.estimators.run.campaign", lambda *arguments: short)
    file, folder = tmp_path / "rows.json", tmp_path / "pictures"
    assert main(["benchmark", "estimators", "--trials", "1", "--json", str(file), "--out", str(folder)]) == 0
    printed = capsys.readouterr().out
    assert "timestamps" in printed
    assert "only exchanges the datagrams" in printed
    result = json.loads(file.read_text())
    assert set(result["rows"][0]) >= CONTRACT
    assert {path.name for path in folder.iterdir()} == {
        "predictions.png", "error_mean_against_noise.png", "delay_rms_s_against_noise.png",
    }  # fmt: skip
    assert main(["benchmark", "vision", "--quick"]) == 1
    assert "--quick: only for `benchmark estimators`" in capsys.readouterr().err
    assert main(["benchmark", "estimators", "--trials", "0"]) == 1
    assert "--trials 0: at least 1" in capsys.readouterr().err
