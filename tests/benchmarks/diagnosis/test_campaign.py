"""The campaign's marks, rates and resumption, with a world and a diagnosis that are made up."""

import json
from pathlib import Path
from typing import Any

import pytest

from stillarm.benchmarks.diagnosis.campaign import run, schedule
from stillarm.benchmarks.diagnosis.hidden import hidden_world
from stillarm.benchmarks.diagnosis.mark import mark
from stillarm.benchmarks.diagnosis.picture import draw_campaign
from stillarm.benchmarks.diagnosis.summary import summary, wilson
from stillarm.benchmarks.diagnosis.tables import lines
from stillarm.benchmarks.diagnosis.trial import trial
from stillarm.common.user_error import UserError

HIDDEN = {
    "cause": "drive_dead_time",
    "variant": "",
    "parameters": {"dead_time_s": 0.006},
    "size": "dead_time_s",
    "departure": 0.004,
    "law": False,
    "nats": 120.0,
}


def truth(kind: str = "one", hidden: list[dict[str, Any]] | None = None) -> dict[str, Any]:
    return {
        "kind": kind,
        "seed": 1,
        "number": 0,
        "duration_s": 20.0,
        "hidden": [HIDDEN] if hidden is None else hidden,
        "hold_out": [[1.0, 2.0]],
        "floor": {"acceleration_m_s2": 0.3},
        "strongest": "acceleration_m_s2",
        "over_noise": 0.2,
    }


def finding(
    cause: str, value: float = 0.006, confidence: float = 0.9, others: tuple[str, ...] = ()
) -> dict[str, Any]:
    return {
        "cause": cause,
        "confidence": confidence,
        "parameters": {"dead_time_s": {"value": value, "std": 1e-4}},
        "indistinguishable_from": list(others),
    }


def asked(*findings: dict[str, Any], verdict: str | None = None) -> dict[str, Any]:
    answer = {
        "verdict": verdict or ("named" if findings else "none"),
        "findings": list(findings),
        "channels": {"acceleration_m_s2": {"nrmse_before": 0.5, "nrmse_after": 0.32}},
    }
    return {"seconds": 9.0, "answer": answer, "error": None}


def test_the_right_cause_is_right_and_measured_by_what_departs() -> None:
    row = mark(truth(), asked(finding("drive_dead_time", 0.0062)))
    assert row["right"] and not row["misnamed"]
    assert row["parameter_error"] == pytest.approx(0.05)  # 0.2 ms of 4 ms
    assert row["value_errors"]["dead_time_s"] == pytest.approx(0.2 / 6.0)
    assert row["gain_ratio"] == pytest.approx((0.25 - 0.1024) / (0.25 - 0.09))


def test_another_cause_is_wrong_and_a_class_counts_only_where_it_is_inseparable() -> None:
    assert not mark(truth(), asked(finding("drive_lag")))["right"]
    assert not mark(truth(), asked(finding("drive_lag", others=("drive_dead_time",))))["right"]
    assert mark(truth(), asked(finding("accelerometer_lag", others=("drive_dead_time",))))["right"]
    both = ("drive_dead_time", "cubic_stiffness")
    assert not mark(truth(), asked(finding("accelerometer_lag", others=both)))["right"]
    assert not mark(truth(), asked(finding("cubic_stiffness"), finding("drive_dead_time")))["right"]


def test_nothing_hidden_asks_for_nothing_found() -> None:
    assert mark(truth("none", []), asked())["right"]
    assert not mark(truth("none", []), asked(verdict="unexplained"))["right"]
    assert not mark(truth("none", []), asked(finding("drive_lag", confidence=0.1)))["right"]


def test_an_unknown_effect_asks_for_unexplained_and_no_confident_name() -> None:
    gusts = [HIDDEN | {"cause": "gusts", "size": "amount", "parameters": {"amount": 1.0}}]
    assert mark(truth("unknown", gusts), asked(verdict="unexplained"))["right"]
    named = mark(truth("unknown", gusts), asked(finding("cubic_stiffness")))
    assert not named["right"] and named["misnamed"]
    unsure = mark(
        truth("unknown", gusts), asked(finding("cubic_stiffness", confidence=0.2), verdict="unexplained")
    )
    assert unsure["right"] and not unsure["misnamed"] and unsure["answer"] == "unexplained"


def test_two_effects_ask_for_both_in_any_order() -> None:
    two = [HIDDEN, HIDDEN | {"cause": "tracking_drift"}]
    assert mark(truth("two", two), asked(finding("tracking_drift"), finding("drive_dead_time")))["right"]
    assert not mark(truth("two", two), asked(finding("drive_dead_time")))["right"]


def test_a_diagnosis_that_fails_is_a_miss_of_every_kind() -> None:
    for kind in ("one", "none", "unknown", "two"):
        row = mark(truth(kind), {"seconds": 1.0, "answer": None, "error": "diagnose: no"})
        assert not row["right"] and row["answer"] == "failed"


def test_wilson_as_in_the_textbook() -> None:
    """Agresti and Coull 1998: 0 of 10 gives 0 to 0.278; 50 of 100 gives 0.404 to 0.596."""
    assert wilson(0, 10) == pytest.approx([0.0, 0.2775], abs=1e-3)
    assert wilson(50, 100) == pytest.approx([0.4038, 0.5962], abs=1e-3)


def test_the_schedule_mixes_the_kinds() -> None:
    plan = schedule(200)
    assert [sum(kind == k for kind, _ in plan) for k in ("one", "none", "unknown", "two")] == [
        200,
        100,
        40,
        40,
    ]
    assert {kind for kind, _ in plan[:12]} == {"one", "none", "unknown", "two"}


def test_rates_and_misses() -> None:
    rows = [mark(truth(), asked(finding(c))) for c in ("drive_dead_time", "drive_dead_time", "drive_lag")]
    rows.append(mark(truth("none", []), asked()))
    result = summary(rows, 3, 5)
    assert result["naming_rate"] == pytest.approx(2 / 3)
    assert result["false_alarm_rate"] == 0.0 and result["unexplained_rate"] is None
    assert result["confusion"] == {
        "drive_dead_time": {"drive_dead_time": 2, "drive_lag": 1},
        "none": {"none": 1},
    }
    assert len(result["misses"]) == 1
    text = "\n".join(lines(result))
    assert "2 of 3" in text and "miss: --seed 5, one 0" in text
    json.dumps(result, allow_nan=False)


def test_a_least_size_takes_three_trials() -> None:
    rows = [
        mark(truth(hidden=[HIDDEN | {"nats": nats}]), asked(finding(cause)))
        for nats, cause in (
            (60.0, "drive_lag"),
            (90.0, "drive_dead_time"),
            (120.0, "drive_dead_time"),
            (150.0, "drive_dead_time"),
        )
    ]
    by_cause = summary(rows, 4, 1)["by_cause"]["drive_dead_time"]
    assert by_cause["least_nats_80_percent"] == 90.0
    assert summary(rows[2:], 2, 1)["by_cause"]["drive_dead_time"]["least_nats_80_percent"] is None


def test_pictures_are_drawn_where_no_cause_has_a_least_size(tmp_path: Path) -> None:
    draw_campaign(summary([mark(truth(), asked(finding("drive_lag")))], 1, 1), tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"confusion.png", "sizes.png"}


def test_a_campaign_goes_on_where_it_stopped(tmp_path: Path) -> None:
    made: list[tuple[str, int]] = []

    def prepare(kind: str, number: int, seed: int, folder: Path) -> dict[str, Any]:
        if len(made) == 4:
            raise KeyboardInterrupt
        made.append((kind, number))
        return truth(kind, [] if kind == "none" else [HIDDEN, HIDDEN] if kind == "two" else [HIDDEN])

    def answer(bundle: Path, work: Path, hold_out: list[list[float]]) -> dict[str, Any]:
        assert bundle.name == "data" and hold_out == [[1.0, 2.0]]
        return asked(finding("drive_dead_time"))

    def one(kind: str, number: int, seed: int) -> dict[str, Any]:
        return trial(kind, number, seed, prepare, answer)

    with pytest.raises(KeyboardInterrupt):
        run(4, 3, tmp_path, trial=one)
    first = list(made)
    made.clear()
    result = run(4, 3, tmp_path, trial=one)
    assert not set(first) & set(made) and len(first) + len(made) == 8
    assert result["counts"]["naming_rate"] == [4, 4]
    for name in ("confusion.png", "sizes.png"):
        assert (tmp_path / name).stat().st_size > 5000
    with pytest.raises(UserError, match="seed 3"):
        run(4, 9, tmp_path, trial=one)


def test_a_folder_of_other_files_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("x")
    with pytest.raises(UserError, match="other files"):
        run(1, 0, tmp_path, trial=lambda kind, number, seed: {})


def test_the_hidden_world_is_found_in_the_source_tree_or_said_to_be_missing(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    assert callable(hidden_world())
    monkeypatch.setattr("stillarm.benchmarks.diagnosis.hidden._ROOT", tmp_path)
    with pytest.raises(UserError, match="source tree"):
        hidden_world()
