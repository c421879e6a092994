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
    "form": "fixed",
    "onset_s": 0.0,
    "size_in_noise": 4.0,
    "parameters": {"dead_time_s": 0.006, "extra_dead_time_s": 0.004, "onset_s": 3.0},
    "same": [],
    "matters": True,
    "comparable": True,
}
GUSTS = HIDDEN | {"cause": "random_tip_force", "form": "gusts", "parameters": {}}


def truth(kind: str = "one", *hidden: dict[str, Any], **more: Any) -> dict[str, Any]:
    """Of a trial that hides some effects, the first the largest; of the kind `one` HIDDEN if none are given."""
    effects = list(hidden) or ([HIDDEN] if kind == "one" else [])
    expected = {"none": "none", "unknown": "unexplained"}.get(kind, "named")
    return {
        "kind": kind,
        "seed": 1,
        "number": 0,
        "duration_s": 20.0,
        "expected": expected,
        "cause": effects[0]["cause"] if effects else None,
        "also": effects[0]["same"] if effects and expected == "named" else [],
        "doubtful": False,
        "size_in_noise": max((one["size_in_noise"] for one in effects), default=0.0),
        "hidden": effects,
        "floor": {"acceleration": 0.3},
        "strongest": "acceleration",
        "oracle_nats": 1200.0,
    } | more


def finding(
    cause: str, value: float = 0.006, others: tuple[str, ...] = (), confidence: float = 0.9
) -> dict[str, Any]:
    return {
        "cause": cause,
        "confidence": confidence,
        "parameters": {"dead_time_s": {"value": value, "std": 1e-4}, "onset_s": {"value": 9.0, "std": 1.0}},
        "indistinguishable_from": list(others),
    }


def asked(
    *findings: dict[str, Any], verdict: str | None = None, left_out: tuple[str, ...] = ()
) -> dict[str, Any]:
    answer = {
        "verdict": verdict or ("named" if findings else "none"),
        "findings": list(findings),
        "channels": {"acceleration": {"nrmse_before": 0.5, "nrmse_after": 0.32}},
        "looked_at": {"left_out": list(left_out)},
    }
    return {"seconds": 9.0, "answer": answer, "error": None}


def test_the_right_cause_is_right_and_its_parameters_are_compared_by_name() -> None:
    row = mark(truth(), asked(finding("drive_dead_time", 0.0063)))
    assert row["right"] and row["named"] and not row["misnamed"] and row["answer"] == "drive_dead_time"
    assert row["value_errors"] == {"dead_time_s": pytest.approx(0.05)}
    assert row["parameter_error"] == pytest.approx(0.05)
    assert row["gain_ratio"] == pytest.approx((0.25 - 0.1024) / (0.25 - 0.09))


def test_what_cannot_be_compared_is_left_out() -> None:
    told = asked(finding("drive_dead_time", 0.0063))
    jitter = mark(truth("one", HIDDEN | {"comparable": False}), told)
    assert jitter["right"] and jitter["parameter_error"] is None
    by_class = mark(truth(), asked(finding("drive_lag", others=("drive_dead_time",))))
    assert by_class["right"] and by_class["parameter_error"] is None
    assert mark(truth(strongest="image_timing"), told)["gain_ratio"] is None
    part = asked(finding("drive_dead_time"), left_out=("time after 20 s",))
    assert mark(truth(), part)["gain_ratio"] is None


def test_another_cause_is_wrong_and_misnamed_unless_it_is_in_a_class_of_two_or_the_same_law() -> None:
    other = mark(truth(), asked(finding("drive_lag")))
    assert not other["right"] and other["misnamed"]
    assert mark(truth(), asked(finding("drive_lag", others=("drive_dead_time",))))["right"]
    three = ("drive_dead_time", "cubic_stiffness")
    assert not mark(truth(), asked(finding("drive_lag", others=three)))["right"]
    assert not mark(truth(), asked(finding("drive_lag"), finding("drive_dead_time")))["right"]
    same = mark(truth("one", HIDDEN | {"same": ["accelerometer_lag"]}), asked(finding("accelerometer_lag")))
    assert same["right"] and same["named"] and not same["misnamed"]


def test_the_name_without_the_verdict_is_a_miss() -> None:
    row = mark(truth(), asked(finding("drive_dead_time"), verdict="unexplained"))
    assert not row["right"] and not row["named"] and not row["misnamed"] and row["answer"] == "unexplained"


def test_nothing_hidden_asks_for_none() -> None:
    assert mark(truth("none"), asked())["right"] and not mark(truth("none"), asked())["false_alarm"]
    unexplained = mark(truth("none"), asked(verdict="unexplained"))
    assert not unexplained["right"] and unexplained["false_alarm"] and not unexplained["misnamed"]
    named = mark(truth("none"), asked(finding("drive_lag")))
    assert not named["right"] and named["false_alarm"] and named["misnamed"]


def test_an_unlisted_effect_asks_for_unexplained() -> None:
    assert mark(truth("unknown", GUSTS), asked(verdict="unexplained"))["right"]
    beside = mark(truth("unknown", GUSTS), asked(finding("cubic_stiffness"), verdict="unexplained"))
    assert beside["right"] and not beside["misnamed"]
    named = mark(truth("unknown", GUSTS), asked(finding("cubic_stiffness")))
    assert not named["right"] and named["misnamed"]


@pytest.mark.parametrize(("kind", "effect"), [("one", HIDDEN), ("unknown", GUSTS)])
def test_an_effect_that_does_not_matter_asks_for_none(kind: str, effect: dict[str, Any]) -> None:
    small = truth(kind, effect | {"size_in_noise": 0.05, "matters": False}, expected="none")
    assert mark(small, asked())["right"]
    assert not mark(small, asked(verdict="unexplained"))["right"]
    named = mark(small, asked(finding(effect["cause"])))
    assert not named["right"] and not named["misnamed"]


def test_two_effects_ask_for_all_that_matter_in_any_order() -> None:
    drift = HIDDEN | {"cause": "tracking_drift", "same": ["lens_distortion"]}
    two = truth("two", HIDDEN, drift)
    assert mark(two, asked(finding("tracking_drift"), finding("drive_dead_time")))["right"]
    assert mark(two, asked(finding("drive_dead_time"), finding("lens_distortion")))["right"]
    in_class = finding("drive_lag", others=("drive_dead_time",))
    assert mark(two, asked(finding("tracking_drift"), in_class))["right"]
    one = mark(two, asked(finding("drive_dead_time")))
    assert not one["right"] and not one["misnamed"]
    open_still = asked(finding("tracking_drift"), finding("drive_dead_time"), verdict="unexplained")
    assert not mark(two, open_still)["right"]
    small = truth("two", HIDDEN, drift | {"matters": False})
    assert mark(small, asked(finding("drive_dead_time")))["right"]


def test_a_diagnosis_that_fails_is_a_miss_of_every_kind() -> None:
    for kind in ("one", "none", "unknown", "two"):
        row = mark(truth(kind), {"seconds": 1.0, "answer": None, "error": "diagnose: no"})
        assert not row["right"] and row["answer"] == "failed" and not row["misnamed"]
        assert row["false_alarm"] == (kind == "none")


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
    small = HIDDEN | {"size_in_noise": 0.05, "matters": False}
    rows.append(mark(truth("one", small, expected="none", oracle_nats=3.0), asked()))
    rows.append(mark(truth("none"), asked()))
    result = summary(rows, 4, 5)
    assert result["naming_rate"] == pytest.approx(3 / 4)
    assert result["too_small"]["naming_rate"] == [1, 1]
    assert result["counts"]["misnamed_rate"] == [1, 5]
    assert result["compared"] == {"parameter_error_median": 2, "gain_ratio_median": 2}
    assert result["false_alarm_rate"] == 0.0 and result["unexplained_rate"] is None
    assert result["confusion"] == {
        "drive_dead_time": {"drive_dead_time": 2, "drive_lag": 1, "none": 1},
        "none": {"none": 1},
    }
    assert len(result["misses"]) == 1
    text = "\n".join(lines(result))
    assert "3 of 4" in text and "said of 1 of 1" in text and "of 2 trials, wanted <= 3 %" in text
    assert (
        "miss: --seed 5, one 0: drive_dead_time (fixed) of 4; expected named; answered named drive_lag"
        in text
    )
    json.dumps(result, allow_nan=False)


def test_detection_over_size_stands_beside_an_oracle_s_limit() -> None:
    sizes_nats = ((0.05, 3.0), (4.0, 1200.0), (6.0, None))
    rows = [
        mark(
            truth("one", HIDDEN | {"size_in_noise": size}, oracle_nats=nats),
            asked(finding("drive_dead_time")),
        )
        for size, nats in sizes_nats
    ]
    result = summary(rows, 3, 1)
    small, large = result["by_size"]
    assert (small["from_size"], small["to_size"], small["oracle"]) == (0.0, 0.15, [0, 1])
    assert (large["trials"], large["detected"], large["named"], large["oracle"]) == (2, 2, 2, [1, 1])
    # nats grow with the square: 0.05 sqrt(12 / 3) = 0.1, and 4 sqrt(12 / 1200) = 0.4
    assert result["oracle"]["size_in_noise_median"] == pytest.approx(0.25)
    assert result["oracle"]["trials"] == 2


def test_a_least_size_takes_three_trials() -> None:
    rows = [
        mark(truth("one", HIDDEN | {"size_in_noise": size}), asked(finding(cause)))
        for size, cause in (
            (1.5, "drive_lag"),
            (2.0, "drive_dead_time"),
            (5.0, "drive_dead_time"),
            (9.0, "drive_dead_time"),
        )
    ]
    by_cause = summary(rows, 4, 1)["by_cause"]["drive_dead_time"]
    assert by_cause["least_size_80_percent"] == 2.0
    assert summary(rows[2:], 2, 1)["by_cause"]["drive_dead_time"]["least_size_80_percent"] is None


def test_pictures_are_drawn_where_no_cause_has_a_least_size(tmp_path: Path) -> None:
    draw_campaign(summary([mark(truth(), asked(finding("drive_lag")))], 1, 1), tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"confusion.png", "sizes.png"}


def test_a_campaign_goes_on_where_it_stopped(tmp_path: Path) -> None:
    made: list[tuple[str, int]] = []

    def prepare(kind: str, number: int, seed: int, folder: Path) -> dict[str, Any]:
        if len(made) == 4:
            raise KeyboardInterrupt
        made.append((kind, number))
        return truth(kind, *{"none": [], "two": [HIDDEN, HIDDEN]}.get(kind, [HIDDEN]))

    def answer(bundle: Path, work: Path) -> dict[str, Any]:
        assert bundle.name == "data"
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


def test_rows_of_the_earlier_benchmark_are_not_mixed_with_these(tmp_path: Path) -> None:
    (tmp_path / "campaign.json").write_text(json.dumps({"seed": 0, "trials": 1}))
    with pytest.raises(UserError, match="earlier benchmark"):
        run(1, 0, tmp_path, trial=lambda kind, number, seed: {})


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
