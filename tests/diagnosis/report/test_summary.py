"""The three sentences with which a report begins, for each verdict: what is wrong, how sure, what to do."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from stillarm.common.causes import CAUSES
from stillarm.common.files.model import Model
from stillarm.diagnosis.decision.decide import Judged
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.fitting.rest import Rest
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.report.result import Result
from stillarm.diagnosis.report.summary import summary
from stillarm.diagnosis.report.tables import NOTHING_LIKE_IT
from stillarm.diagnosis.report.words import rounded_cut
from stillarm.diagnosis.search.candidates import Candidate, Found, Stage
from tests.fixtures.synthetic import MODEL, measured

LEFT = {
    "channel": "displacement",
    "band_hz": [2.0, 4.5],
    "dependence": "a force that depends on the deflection",
    "term": "",
}


def candidate(cause: str, merit: float) -> Candidate:
    return Candidate(cause, cast(Fit, SimpleNamespace()), 0.0, 0.0, {}, merit=merit, nats=np.zeros(3))


def row(
    cause: str, confidence: float, near: tuple[str, ...] = (), experiment: str | None = None
) -> dict[str, Any]:
    held_out = {"reduction": 0.5, "log_score_gain": 80.0}
    return {
        "cause": cause, "confidence": confidence, "indistinguishable_from": list(near), "held_out": held_out,
        "experiment": experiment,
    }  # fmt: skip


@pytest.fixture(scope="module")
def world() -> World:
    """A recording of all channels, in which everything moves."""
    return World(measured(6.0, 1), MODEL)


def result_of(
    world: World,
    verdict: str,
    rows: list[dict[str, Any]] | None = None,
    rivals: tuple[Candidate, ...] = (),
    left: dict[str, Any] | None = None,
    left_out: tuple[str, ...] = (),
    changes: tuple[str, ...] = (),
    rests: tuple[Rest, ...] = (),
) -> Result:
    baseline = cast(Fit, SimpleNamespace(world=world))
    found = Found(baseline, baseline)
    for one in rows or []:
        taken = candidate(one["cause"], 100.0)
        found.findings.append(taken)
        found.stages.append(Stage([], [taken, *rivals], taken))
    table = {
        "verdict": verdict, "findings": rows or [], "unexplained": left, "looked_at": {"left_out": list(left_out)},
        "baseline_changes": {key: {} for key in changes},
    }  # fmt: skip
    judged = Judged(verdict, list(rests), None, None)
    return Result(table, found, judged, cast(Any, None), Model(), Model())


def test_each_ends_with_a_full_stop_and_begins_with_a_capital(world: World) -> None:
    for result in (
        result_of(world, "named", [row("drive_lag", 0.97)]),
        result_of(world, "none"),
        result_of(world, "unexplained", left=LEFT),
    ):
        for sentence in summary(result):
            assert sentence[0].isupper() and sentence.endswith(".") and not sentence.endswith("..")
            assert "  " not in sentence


def test_a_name_its_confidence_and_its_best_rival(world: World) -> None:
    rivals = (candidate("drive_saturation", 40.0), candidate("joint_friction", 5.0))
    wrong, sure, do = summary(result_of(world, "named", [row("drive_lag", 0.97)], rivals))
    assert wrong == (
        "The simulation lacks a drive of another bandwidth than declared (the held-out error falls by 50 %)."
    )
    assert sure == (
        f"The confidence in this is 97 %: the next best explanation, {CAUSES['drive_saturation'].name}, foretells the "
        "recording worse by 60 nats."
    )
    assert do == (
        "Mend it, or use extended.toml, the model with it; to confirm it, record this: moves with steep ramps, the "
        "encoder recorded."
    )


def test_the_declared_experiment_separates_a_name_from_its_rival(world: World) -> None:
    rival = candidate("accelerometer_lag", 40.0)
    _, _, do = summary(result_of(world, "named", [row("drive_lag", 0.97)], (rival,)))
    assert CAUSES["drive_lag"].confused_with["accelerometer_lag"] in do
    assert do.startswith("Mend it, or use extended.toml") and CAUSES["accelerometer_lag"].name in do


def test_a_rival_that_explains_nothing_is_none(world: World) -> None:
    _, sure, _ = summary(
        result_of(world, "named", [row("drive_lag", 0.999)], (candidate("joint_friction", -3.0),))
    )
    assert sure == "The confidence in this is 99 %: no other cause gains more than chance."


def test_of_two_that_cannot_be_told_apart_both_are_named_with_their_experiment(world: World) -> None:
    two = row("drive_lag", 0.48, ("accelerometer_lag",), "record the joint's encoder")
    wrong, sure, do = summary(result_of(world, "named", [two], (candidate("accelerometer_lag", 99.0),)))
    assert CAUSES["drive_lag"].name in wrong and CAUSES["accelerometer_lag"].name in wrong
    assert sure == "The confidence in each of these two names is 48 %: this recording cannot tell them apart."
    assert do == "To tell the two apart, record the joint's encoder."


def test_each_finding_has_its_confidence(world: World) -> None:
    wrong, sure, _ = summary(result_of(world, "named", [row("drive_lag", 0.97), row("mains_hum", 0.8)]))
    assert CAUSES["drive_lag"].name in wrong and CAUSES["mains_hum"].name in wrong
    assert sure.endswith(f"; in {CAUSES['mains_hum'].name} it is 80 %.")


def test_nothing_wrong_says_how_much_was_looked_at_and_what_is_left(world: World) -> None:
    rest = Rest("displacement", 0.011, 0.22, True, (1.0, 3.0))
    wrong, sure, do = summary(result_of(world, "none", rests=(rest,)))
    assert wrong.startswith("Nothing is wrong with this simulation")
    assert sure.startswith("Of ") and "none gains more than chance" in sure
    assert sure.endswith("no more is left than 0.011 px in the image displacement, 0.22 of its noise.")
    assert do == "Keep the model, and diagnose again after the rig has been changed, or has aged."
    _, sure, _ = summary(result_of(world, "none"))
    assert sure.endswith("and nothing but noise is left.")


def test_parameters_that_were_off_are_to_be_taken_over(world: World) -> None:
    keys = ("arm.modes[0].frequency_hz", "accelerometer.bias_m_s2")
    _, _, do = summary(result_of(world, "none", changes=keys))
    assert do.startswith(f"Take over the refitted {', '.join(keys)} from extended.toml, and diagnose again")
    _, _, many = summary(result_of(world, "none", changes=("a", "b", "c", "d")))
    assert "a, b, c and more from" in many


def test_what_has_no_name_is_told_by_what_it_looks_like(world: World) -> None:
    wrong, sure, do = summary(result_of(world, "unexplained", left=LEFT))
    assert wrong.startswith("The image displacement holds structure at 2 to 4.5 Hz")
    assert sure == (
        "No listed cause gains more than chance, and what is left looks most like a force that depends on the "
        "deflection."
    )
    assert do == "Record again with that alone varied, all else at rest, and diagnose both recordings."


def test_what_resembles_nothing_is_sought_as_a_resonance(world: World) -> None:
    left = LEFT | {"dependence": NOTHING_LIKE_IT}
    _, sure, do = summary(result_of(world, "unexplained", [row("drive_lag", 0.1)], left=left))
    assert sure.startswith(
        f"The listed cause that comes closest is {CAUSES['drive_lag'].name}, at a confidence of 10 %"
    )
    assert sure.endswith("resembles nothing that was tried.")
    assert do.startswith("Look for resonances of the rig between 2 and 4.5 Hz")


def test_what_the_time_did_not_suffice_for_is_told_beside_how_sure_it_is(world: World) -> None:
    for verdict, rows, left in (
        ("none", [], None),
        ("named", [row("drive_lag", 0.9)], None),
        ("unexplained", [], LEFT),
    ):
        cut = result_of(world, verdict, rows, left=left, left_out=("impacts", "use"))
        assert summary(cut)[1].endswith("; the time did not suffice for impacts.")


def test_a_cut_that_is_nearly_all_is_not_said_to_be_all() -> None:
    assert [rounded_cut(one) for one in (49.6, 99.4, 99.97, 100.0)] == ["50", "99", "more than 99", "100"]
