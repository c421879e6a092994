"""The confidence that is stated against how often it is right."""

import json
from pathlib import Path
from typing import Any

import pytest

from stillarm.benchmarks.diagnosis.reliability import bins, expected_calibration_error, judged, main
from stillarm.common.user_error import UserError


def finding(cause: str, confidence: float, *near: str) -> dict[str, Any]:
    return {"findings": [{"cause": cause, "confidence": confidence, "indistinguishable_from": list(near)}]}


@pytest.mark.parametrize(
    ("answer", "expected"),
    [
        (finding("a", 0.9), (0.9, True)),
        (finding("b", 0.4, "a"), (0.4, True)),
        (finding("b", 0.4, "a", "c"), (0.4, False)),
        (finding("d", 0.8), (0.8, True)),
        (finding("e", 0.8), (0.8, False)),
        ({"findings": []}, None),
    ],
)
def test_the_first_finding_or_its_class_of_two_is_judged(answer: Any, expected: Any) -> None:
    truth = {"expected": "named", "cause": "a", "also": [], "effects": [{"cause": "a"}, {"cause": "d"}]}
    assert judged(truth, answer) == expected


def test_nothing_hidden_makes_every_name_wrong() -> None:
    assert judged({"expected": "none", "cause": None}, finding("a", 0.95)) == (0.95, False)


def test_the_error_is_the_distance_of_what_is_said_from_what_is_right() -> None:
    # nine of ten right at 0.9 is calibrated; one of two right at 0.8 is 0.3 off
    calibrated = [(0.9, True)] * 9 + [(0.9, False)]
    sure = [(0.8, True), (0.8, False)]
    assert expected_calibration_error(bins(calibrated)) == pytest.approx(0.0)
    assert expected_calibration_error(bins(sure)) == pytest.approx(0.3)
    assert expected_calibration_error(bins(calibrated + sure)) in (
        pytest.approx(0.6 / 12),
        pytest.approx(abs(10 - 10.6) / 12),  # where both fall into one bin
    )


def test_folders_are_read_and_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for number, cause in enumerate(("a", "b"), 1):
        (tmp_path / "cases" / f"case_{number:04d}").mkdir(parents=True)
        (tmp_path / "results" / f"case_{number:04d}").mkdir(parents=True)
        truth = {"expected": "named", "cause": "a"}
        (tmp_path / "cases" / f"case_{number:04d}" / "truth.json").write_text(json.dumps(truth))
        said = tmp_path / "results" / f"case_{number:04d}" / "diagnosis.json"
        said.write_text(json.dumps(finding(cause, 0.95)))
    picture = tmp_path / "reliability.png"
    main([str(tmp_path / "cases"), str(tmp_path / "results"), "--picture", str(picture)])
    assert "said 0.95: right 1 of 2" in capsys.readouterr().out
    assert picture.stat().st_size > 1000


def test_folders_without_their_pair_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="in pairs"):
        main([str(tmp_path)])
