"""Cases of a folder are answered once each, whoever asks."""

from pathlib import Path

import pytest

from stillarm.benchmarks.diagnosis.cases import answer_all, once


def test_each_case_is_answered_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for number in (1, 2):
        (tmp_path / "cases" / f"case_{number:04d}").mkdir(parents=True)
    taken = tmp_path / "results" / "case_0001"
    assert once(lambda case, folder, budget_s: "said", tmp_path / "cases" / "case_0001", taken, 1.0) == "said"
    answer_all(lambda case, folder, budget_s: f"{folder.name} {budget_s:.0f}", "a.writer", [
        str(tmp_path / "cases"), str(tmp_path / "results"), "--budget-s", "7",
    ])  # fmt: skip
    assert capsys.readouterr().out == "case_0002: case_0002 7\n"


def test_a_folder_without_cases_says_who_writes_some(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match=r"holds no case_\*; write some with python -m a\.writer"):
        answer_all(lambda case, folder, budget_s: "", "a.writer", [str(tmp_path), str(tmp_path / "results")])
