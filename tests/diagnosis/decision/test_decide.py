"""The verdict: what counts as explained, as left, and as told apart."""

from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision import decide
from stillarm.diagnosis.decision.decide import (
    MOST_CONFIDENCE,
    Judged,
    _left_to_explain,
    _odds_of_name,
    judge,
    share_explained,
)
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.fitting.rest import Rest, explainable
from stillarm.diagnosis.forms.force_terms import own_frequencies_hz
from stillarm.diagnosis.forms.freeform import Free, Group
from stillarm.diagnosis.physics.computing import OutOfTime
from stillarm.diagnosis.physics.space import Added
from stillarm.diagnosis.search.candidates import Found, Stage
from tests.fixtures.candidates import bare_candidate
from tests.fixtures.synthetic import fitted, measured, with_rest

SPLIT = interleaved(20.0)


@pytest.fixture(scope="module")
def arm() -> Fit:
    return fitted(measured(20.0, 3))


def test_nothing_hidden_is_none(arm: Fit) -> None:
    found = Found(arm, arm)
    judged = judge(found, SPLIT)
    assert judged.verdict == "none"


def test_a_third_finding_is_hardly_sure(arm: Fit, monkeypatch: pytest.MonkeyPatch) -> None:
    """What two formulas leave that are not quite the true ones looks like a further cause."""
    monkeypatch.setattr(decide, "_odds_of_name", lambda *_, **__: 1.0)
    monkeypatch.setattr(decide, "_odds_beside", lambda *_: 1.0)
    monkeypatch.setattr(decide, "best_free", lambda *_: None)
    causes = ("cubic_stiffness", "tracking_drift", "drive_lag")
    found = Found(arm, arm, [replace(bare_candidate(cause, 500.0), fit=arm) for cause in causes])
    found.stages += [Stage([], [one], one) for one in found.findings]
    first, second, third = judge(found, SPLIT).confidence.values()
    assert first == second == MOST_CONFIDENCE and third <= 0.22


def test_the_largest_rest_is_told_first() -> None:
    rests: list[Any] = [
        Rest("acceleration", 1.0, 0.7, immaterial=False, band_hz=(0.0, 1.0)),
        Rest("displacement", 1.0, 4.0, immaterial=False, band_hz=(0.0, 1.0)),
        Rest("arrival", 1.0, 9.0, immaterial=True, band_hz=(0.0, 1.0)),
    ]
    left = Judged("unexplained", rests, None, None).left
    assert left is not None and left.channel == "displacement"


@pytest.mark.parametrize(("left", "named"), [(0.0, True), (1.0, True), (7.0, False)])
def test_a_course_that_leaves_much_of_what_it_follows_is_no_name(arm: Fit, left: float, named: bool) -> None:
    """left: of the images' noise, where they strayed by ten times that. A tip in gusts strays them too fast."""
    time = arm.world.times_of("displacement")
    walk = Added("walk", {"displacement": time[:, None] / 20.0}, 1.0, over_time=True)
    follows = replace(arm, world=arm.world.changed(added=(walk,)))
    before = with_rest(arm, "displacement", 10.0 * arm.sigma["displacement"])
    first = replace(
        bare_candidate("tracking_drift", 500.0, "displacement"),
        fit=with_rest(follows, "displacement", left * arm.sigma["displacement"]),
        nats=np.full(30, 500.0 / 30.0),
    )
    found = Found(before, first.fit, [first])
    assert (_odds_of_name(found, first, SPLIT, None, None) > 0.5) is named


@pytest.mark.parametrize(
    ("times_the_mode", "left", "named"),
    [(1.0, 1.0, True), (1.0, 5.0, False), (2.0, 5.0, False), (1.4, 5.0, True)],
)
def test_a_force_at_a_mode_s_frequency_that_leaves_much_of_what_it_follows_is_no_name(
    arm: Fit, times_the_mode: float, left: float, named: bool
) -> None:
    """left: of the images' noise, where they strayed by ten times that. Gusts ring the arm at its own frequency too."""
    first_hz = own_frequencies_hz(arm)[0]
    before = with_rest(arm, "displacement", 10.0 * arm.sigma["displacement"])
    first = replace(
        bare_candidate("periodic_disturbance", 500.0, "displacement"),
        fit=with_rest(arm, "displacement", left * arm.sigma["displacement"]),
        nats=np.full(30, 500.0 / 30.0),
        values={"frequency_hz": (times_the_mode * first_hz, 0.001)},
    )
    found = Found(before, first.fit, [first])
    assert (_odds_of_name(found, first, SPLIT, None, None) > 0.5) is named


def test_a_hopeless_name_has_no_odds(arm: Fit) -> None:
    """Free terms that gain a hundred times as much: the log odds go below what the exponential function can take."""
    first = replace(bare_candidate("rotor_imbalance", 20.0), fit=replace(arm), nats=np.full(30, 20.0 / 30.0))
    alone = Free(cast(Group, None), 2000.0 * first.merit, "acceleration", arm)
    found = Found(arm, first.fit, [first])
    found.stages.append(Stage([], [first], first))
    assert _odds_of_name(found, first, SPLIT, None, alone) == 0.0


@pytest.mark.parametrize(("free_terms", "named"), [(0.0, True), (400.0, False)])
def test_free_terms_are_asked_where_nothing_matters(
    arm: Fit, free_terms: float, named: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A small departure that a name tells a little of, and a force that is not the same to both sides most."""
    even = Free(cast(Group, None), free_terms, "acceleration", arm)
    monkeypatch.setattr(decide, "best_free", lambda last, *rest: even if last is arm and free_terms else None)
    first = replace(bare_candidate("rotor_imbalance", 20.0), fit=replace(arm), nats=np.full(30, 20.0 / 30.0))
    found = Found(arm, first.fit, [first])
    found.stages.append(Stage([], [first], first))
    assert judge(found, SPLIT).verdict == ("named" if named else "none")


@pytest.mark.parametrize("of_free_form", [True, False])
@pytest.mark.parametrize(("merit", "verdict"), [(1420.0, "unexplained"), (1380.0, "named")])
def test_free_terms_that_tell_as_much_as_two_names_take_the_place_of_both(
    arm: Fit, merit: float, verdict: str, of_free_form: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An accelerometer with an odd gain: clipping and a course of its sensitivity tell it no better than one bend.
    Likewise two formulas. merit: of free terms, where the names have 1400 together. Beside the second, they are worth
    nothing in the place of the first."""
    course = Added(
        "gain", {"acceleration": np.ones((len(arm.residuals["acceleration"]), 1))}, 1.0, over_time=True
    )
    nats = np.full(30, 1000.0 / 30.0)
    first = replace(bare_candidate("accelerometer_clipping", 1000.0), fit=replace(arm), nats=nats)
    follows = replace(arm, world=arm.world.changed(added=(course,) if of_free_form else ()))
    second = replace(bare_candidate("accelerometer_sensitivity_drift", 400.0), fit=follows, nats=nats)
    bend = Free(cast(Group, None), merit, "acceleration", arm)
    monkeypatch.setattr(decide, "best_free", lambda last, *_: bend if last is arm else None)
    monkeypatch.setattr(decide, "beside_the_others", lambda *_: replace(bend, merit=0.0))
    monkeypatch.setattr(decide, "anything_matters", lambda *_: True)
    monkeypatch.setattr(decide, "share_explained", lambda *_, **__: 1.0)
    found = Found(arm, follows, [first, second])
    found.stages += [Stage([], [one], one) for one in found.findings]
    assert judge(found, SPLIT).verdict == verdict


@pytest.mark.parametrize(("share", "verdict"), [(0.9, "named"), (0.6, "unexplained")])
def test_without_time_for_free_terms_a_name_has_to_explain_most(
    arm: Fit, monkeypatch: pytest.MonkeyPatch, share: float, verdict: str
) -> None:
    def no_time(*_: object) -> None:
        raise OutOfTime

    first = replace(bare_candidate("cubic_stiffness", 500.0), fit=arm)
    found = Found(arm, arm, [first])
    found.stages.append(Stage([], [first], first))
    monkeypatch.setattr(decide, "best_free", no_time)
    monkeypatch.setattr(decide, "anything_matters", lambda *_: True)
    monkeypatch.setattr(decide, "share_explained", lambda *_, **__: share)
    judged = judge(found, SPLIT)
    assert judged.left_out == ("structure without a name",)
    assert judged.verdict == verdict


def test_what_others_explain_is_none_of_what_a_finding_lacks(arm: Fit) -> None:
    """A drive's finding tells all of the joint; the arm, which departs by more, is told by another."""
    one = "acceleration"
    loud = with_rest(arm, one, 50.0 * arm.sigma[one])
    turned = with_rest(loud, "joint_velocity", 5.0 * arm.sigma["joint_velocity"])
    turned = replace(turned, world=arm.world.changed(joint_hz=5.0))
    first = replace(
        bare_candidate("drive_deadband", 900.0, "joint_velocity"), fit=loud, nats=np.full(30, 30.0)
    )
    assert share_explained(first, turned, SPLIT) < 0.5
    assert share_explained(first, turned, SPLIT, final=arm) > 0.9


def test_beside_another_finding_a_clock_is_judged_by_the_images_alone(arm: Fit) -> None:
    """What the accelerometer departs by is the other's, or has no name: no clock could tell it."""
    name = "acceleration"
    loud = with_rest(arm, name, 50.0 * arm.sigma[name])
    late = with_rest(loud, "arrival", 5.0 * arm.sigma["arrival"])
    clock = replace(bare_candidate("clock_step", 900.0, "arrival"), fit=loud, nats=np.full(30, 30.0))
    assert share_explained(clock, late, SPLIT) < 0.5
    assert share_explained(clock, late, SPLIT, beside=True) > 0.9


def test_what_another_finding_explains_in_the_same_channel_is_none_of_it_either(arm: Fit) -> None:
    """A stiffness that grows told a part of the acceleration; what another cause told of it after that is not left."""
    name = "acceleration"
    before = with_rest(arm, name, 60.0 * arm.sigma[name])
    part = with_rest(arm, name, 50.0 * arm.sigma[name])
    first = replace(bare_candidate("cubic_stiffness", 900.0, name), fit=part, nats=np.full(30, 30.0))
    assert share_explained(first, before, SPLIT) < 0.2
    assert share_explained(first, before, SPLIT, final=arm) > 0.9


@pytest.mark.parametrize(("left", "is_small"), [(0.45, True), (0.7, False)])
def test_what_does_not_matter_is_as_small_a_part_as_its_rms(arm: Fit, left: float, is_small: bool) -> None:
    """A wave of less than half the noise may be worth as many nats as a slow drift that was ten times as large; one
    that matters counts by its nats."""
    name = "acceleration"
    noise, count = arm.sigma[name], len(arm.residuals[name])
    comes_and_goes = np.arange(count) % 4000 < 1000
    wave = 2.8 * left * noise * np.sin(np.arange(count) / 3.0) * comes_and_goes
    drift = np.linspace(-1.0, 1.0, count) * 8.0 * noise
    after = replace(arm, residuals={**arm.residuals, name: arm.residuals[name] + wave})
    before = replace(after, residuals={**after.residuals, name: after.residuals[name] + drift})
    gained = 100.0
    nats = _left_to_explain(after, before, dict.fromkeys(arm.residuals, gained), SPLIT)[name]
    assert explainable(after, SPLIT)[name] > gained
    assert (
        nats == pytest.approx(0.11 * gained, rel=0.3) if is_small else nats == explainable(after, SPLIT)[name]
    )
