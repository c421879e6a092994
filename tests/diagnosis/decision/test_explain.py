"""The rounds of the search on recordings made by the simulation itself: statistics, not physics."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision import explain as search
from stillarm.diagnosis.decision import rounds
from stillarm.diagnosis.decision.beginning_again import likelier_baseline
from stillarm.diagnosis.decision.explain import _moves_are_told, explain
from stillarm.diagnosis.fitting.evidence import CONVINCING_NATS
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import make_data
from stillarm.diagnosis.fitting.rest import anything_but_spikes_matters
from stillarm.diagnosis.forms.catalogue import forms
from stillarm.diagnosis.physics.computing import OutOfTime
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.search import comparison
from stillarm.diagnosis.search.baseline import moved_as_measured
from stillarm.diagnosis.search.candidates import Candidate, Found, Hint, Stage
from tests.fixtures.synthetic import MODEL, NOISE, fitted, measured

SECONDS = 20.0
STEP_RAD = 2e-3


def _explained(values: dict[str, float], *only: str) -> Found:
    baseline = fitted(measured(SECONDS, 5, values))
    return explain(baseline, interleaved(SECONDS), only=only)


@pytest.mark.slow
def test_nothing_is_found_where_nothing_is_hidden() -> None:
    found = _explained(
        {}, "cubic_stiffness", "tracking_drift", "mains_hum", "accelerometer_lag", "joint_friction"
    )
    assert [one.cause for one in found.findings] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("quantity", "value", "cause"),
    [
        ("camera.rate_px_per_s", 0.1, "tracking_drift"),
        ("accelerometer.gravity_m_s2_per_rad", 5.0, "gravity_leakage"),
        ("arm.cubic_per_m2", 10.0, "cubic_stiffness"),
    ],
)
def test_the_hidden_cause_comes_first(quantity: str, value: float, cause: str) -> None:
    found = _explained(
        {quantity: value}, "tracking_drift", "gravity_leakage", "cubic_stiffness", "lens_distortion"
    )
    assert found.findings[0].cause == cause
    assert found.final.value(quantity) == pytest.approx(value, rel=0.1) or found.findings[0].form


@pytest.mark.slow
def test_what_explains_little_does_not_keep_another_cause_from_being_sought(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Whether the first is a part of something without a name shows beside what else is found alone."""
    monkeypatch.setattr(
        rounds, "share_explained", lambda one, *_, **__: 0.2 if one.cause == "cubic_stiffness" else 1.0
    )
    values = {"accelerometer.gravity_m_s2_per_rad": 5.0, "arm.cubic_per_m2": 10.0}
    found = _explained(values, "gravity_leakage", "cubic_stiffness", "tracking_drift")
    assert [one.cause for one in found.findings] == ["cubic_stiffness", "gravity_leakage"]


@pytest.mark.slow
def test_what_a_sensor_does_is_found_though_nothing_that_matters_is_left() -> None:
    """A dead time takes over most of an accelerometer's lag, of which the joint shows nothing."""
    late_s = 0.0007
    found = _explained(
        {"drive.dead_time_s": 0.01, "accelerometer.delay_s": late_s}, "drive_dead_time", "accelerometer_lag"
    )
    first = found.stages[0].taken
    assert first is not None and not anything_but_spikes_matters(first.fit, interleaved(SECONDS))
    assert [one.cause for one in found.findings] == ["drive_dead_time", "accelerometer_lag"]
    assert found.final.value("accelerometer.delay_s") == pytest.approx(late_s, rel=0.2)


@pytest.mark.slow
def test_a_cause_that_is_not_looked_for_is_not_found() -> None:
    found = _explained({"camera.rate_px_per_s": 0.1}, "cubic_stiffness")
    assert "tracking_drift" not in [one.cause for one in found.findings]


@pytest.mark.slow
@pytest.mark.parametrize(("cause", "asked"), [("tracking_drift", False), ("cubic_stiffness", True)])
def test_another_baseline_is_asked_for_only_where_the_usual_one_leaves_something(
    cause: str, asked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def none_there(*_: object) -> tuple[None, Hint]:
        asked_for.append(cause)
        return None, Hint(baseline, Stage([], [elsewhere], elsewhere))

    baseline = fitted(measured(SECONDS, 5, {"camera.rate_px_per_s": 0.1}))
    drifting = fitted(measured(SECONDS, 5, {"camera.rate_px_per_s": 0.1}), "camera.rate_px_per_s")
    elsewhere = Candidate("tracking_drift", drifting, 0.0, 1.0, {}, free=("camera.rate_px_per_s",), merit=9.0)
    asked_for: list[str] = []
    monkeypatch.setattr(search, "_from_another_baseline", none_there)
    found = explain(baseline, interleaved(SECONDS), only=[cause])
    assert bool(asked_for) is asked
    # what was found there is one more candidate of the round that is made already
    assert [one.cause for one in found.findings] == ["tracking_drift"]


@pytest.mark.slow
def test_lone_spikes_ask_for_no_other_baseline(monkeypatch: pytest.MonkeyPatch) -> None:
    """Their law changes no fit, whatever else a round tells."""

    def never(*_: object) -> tuple[None, None]:
        raise AssertionError("another baseline was asked for")

    data = measured(SECONDS, 5, {"camera.rate_px_per_s": 0.1})
    spikes = np.zeros(data.cycles)
    spikes[np.random.default_rng(3).choice(data.cycles, 60, replace=False)] = 15.0
    baseline = fitted(replace(data, acceleration=data.acceleration + spikes))
    monkeypatch.setattr(search, "_from_another_baseline", never)
    found = explain(baseline, interleaved(SECONDS), only=["tracking_drift"])
    assert [one.cause for one in found.findings] == ["impulse_noise", "tracking_drift"]


@pytest.mark.slow
def test_friction_that_begins_is_found_from_its_beginning() -> None:
    """What acts in a part of the recording is several times larger than what fits the whole."""
    friction, onset_s = 0.1, 12.3
    found = _explained(
        {"arm.coulomb_m_s2": friction, "arm.begin_s": onset_s}, "coulomb_damping", "stiffness_drift"
    )
    first = found.findings[0]
    assert (first.cause, first.begins_s) == ("coulomb_damping", pytest.approx(onset_s, abs=0.1))
    assert found.final.value("arm.coulomb_m_s2") == pytest.approx(friction, rel=0.05)


@pytest.mark.slow
def test_a_baseline_whose_mode_was_fitted_away_is_fitted_again() -> None:
    """From where a form led out of there; that form's own quantity is nothing again."""
    split = interleaved(SECONDS)
    best = fitted(measured(SECONDS, 5))
    world, share, own = best.world, "modes.0.participation", "accelerometer.hum_sin"
    data, free = make_data(world, split), (*best.free, own)
    lost = fit(data, world.space.with_values(best.vector, {share: 0.01}), best.free, iterations=0)
    led_out = fit(data, world.space.with_values(best.vector, {own: 0.1}), free, iterations=0)
    one = Candidate("mains_hum", led_out, 0.0, 0.0, {}, free=(own,))
    again = likelier_baseline(Stage([], [one], one), lost, split)
    assert again is not None and again.free == best.free
    assert again.value(share) == pytest.approx(best.value(share), rel=1e-3)
    assert again.value(own) == world.space[own].start
    assert likelier_baseline(Stage([], [one], one), best, split) is None


@pytest.mark.slow
def test_a_clock_that_was_set_is_found_beside_what_the_drive_did() -> None:
    """What the drive did is sought by itself, and then nothing is left that matters: arrivals change no image."""
    data = measured(SECONDS, 5, {"drive.velocity_loss_rad_s": 0.02})
    received = data.frames.received_s
    set_on = np.where(received > 0.5 * SECONDS, 0.05, 0.0)
    data = replace(data, frames=replace(data.frames, received_s=received + set_on, counted=True))
    split = interleaved(SECONDS)
    world = moved_as_measured(World(data, MODEL), split)
    baseline = fit(make_data(world, split), world.space.vector(), world.baseline_names())
    found = explain(baseline, split, only=("joint_friction", "clock_step"))
    assert [one.cause for one in found.findings] == ["joint_friction", "clock_step"]
    assert found.findings[1].values["step_s"][0] == pytest.approx(0.05, abs=0.005)


@pytest.mark.slow
def test_what_the_drive_did_is_sought_beside_the_usual_baseline_with_its_impacts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The arm is moved by the joint as it was measured: the drive is sought alone, and that tells nothing of impacts,
    nor of another baseline of the arm."""

    def not_asked(*_: object) -> None:
        raise AssertionError

    struck = round(0.6 * SECONDS / 0.001)
    data = measured(SECONDS, 5, {"drive.velocity_loss_rad_s": 0.02})
    split = interleaved(SECONDS)
    world = moved_as_measured(World(data, MODEL), split).changed(impacts=(struck,))
    baseline = fit(make_data(world, split), world.space.vector(), world.baseline_names())
    monkeypatch.setattr(search, "impacts_while_moving", lambda last: [struck])
    monkeypatch.setattr(search, "_from_another_baseline", not_asked)
    monkeypatch.setattr(search, "without_impacts_while_moving", not_asked)
    found = explain(baseline, split, only=("joint_friction",))
    assert [one.cause for one in found.findings] == ["joint_friction"]
    assert struck in found.final.world.impacts


@pytest.mark.slow
def test_an_arm_is_moved_as_a_finding_of_the_drive_foretells() -> None:
    """A coarse encoder moves it by its steps, as long as the drive's model does not foretell the joint."""
    data = measured(SECONDS, 5, {"drive.velocity_loss_rad_s": 0.02})
    coarse = replace(data, position=np.round(data.position / STEP_RAD) * STEP_RAD)
    split = interleaved(SECONDS)
    departing = moved_as_measured(World(coarse, MODEL), split)
    assert departing.joint_hz > 0.0
    begun = fit(make_data(departing, split), departing.space.vector(), departing.baseline_names())
    found = explain(begun, split, only=("joint_friction",))
    assert found.findings[0].cause == "joint_friction"
    assert found.final.world.joint_hz < departing.joint_hz
    assert found.final.sigma["acceleration"] < 1.1 * NOISE["acceleration"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("hidden", "told"),
    [
        ({"accelerometer.gravity_m_s2_per_rad": 5.0}, True),  # shows in the accelerometer alone
        ({"drive.further_dead_time_s": 0.02}, False),  # the joint is late
        ({"camera.rate_px_per_s": 0.1}, False),  # the accelerometer is blind to slow bends
        ({"arm.cubic_per_m2": 30.0}, False),  # all that see the arm see that
    ],
)
def test_moves_are_told_where_the_joint_and_the_images_show_nothing_amiss(
    hidden: dict[str, float], told: bool
) -> None:
    struck = (1000,)
    world = World(measured(SECONDS, 5, {"jump.1.0.v": 0.3} | hidden, struck), MODEL, struck)
    split = interleaved(SECONDS)
    baseline = fit(make_data(world, split), world.space.vector(), world.baseline_names())
    assert _moves_are_told(baseline, split, struck) == told
    assert not _moves_are_told(baseline, split, range(1000, 1100))
    rising = np.flatnonzero(np.diff(baseline.world.measured.told_to_move.astype(int)) > 0)
    in_a_row, spread = rising[4:8].tolist(), rising[[0, 3, 7, len(rising) - 1]].tolist()
    assert not _moves_are_told(baseline, split, in_a_row)
    assert _moves_are_told(baseline, split, spread) == told


@pytest.mark.slow
def test_impacts_that_made_up_for_the_arm_do_not_hide_it_behind_the_drive() -> None:
    """A drive that waits longer, and an arm that stiffens as it bends, for which the baseline has an impact at most of
    the moves: with those nothing is left beside the drive."""
    hidden = {"drive.further_dead_time_s": 0.04, "arm.cubic_per_m2": 100.0}
    split = interleaved(SECONDS)
    world = moved_as_measured(World(measured(SECONDS, 5, hidden), MODEL), split)
    turns = np.flatnonzero(np.diff(world.measured.told_to_move.astype(int))) + 60
    struck = world.changed(impacts=tuple(turns.tolist()))
    baseline = fit(make_data(struck, split), struck.space.vector(), struck.baseline_names())
    found = explain(baseline, split, only=("drive_dead_time", "cubic_stiffness"))
    assert {one.cause for one in found.findings} == {"drive_dead_time", "cubic_stiffness"}
    assert found.final.value("arm.cubic_per_m2") == pytest.approx(100.0, rel=0.05)
    assert len(found.final.world.impacts) < 3


@pytest.mark.slow
def test_what_was_found_beside_another_baseline_is_fitted_before_the_time_is_over(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def no_time(*_: object) -> None:
        raise OutOfTime

    data, split = measured(SECONDS, 5, {"camera.rate_px_per_s": 0.1}), interleaved(SECONDS)
    baseline, elsewhere = fitted(data), fitted(data, "camera.rate_px_per_s")
    hint = Candidate("tracking_drift", elsewhere, 0.0, 1.0, {}, free=("camera.rate_px_per_s",), merit=100.0)
    (course,) = (
        one for one in forms(baseline.world) if (one.id, one.name) == ("tracking_drift", "along a course")
    )
    assert course.added is not None
    terms = course.added(baseline)
    world = baseline.world.changed(added=terms)
    along = fit(make_data(world, split), world.space.vector(), (*baseline.free, *terms[0].amounts))
    by_course = replace(hint, fit=along, free=terms[0].amounts, form=course.name)
    monkeypatch.setattr(comparison, "begun_fits", no_time)
    for given, causes in ((hint, ["tracking_drift"]), (by_course, ["tracking_drift"]), (None, [])):
        told = Hint(elsewhere, Stage([], [given], given)) if given is not None else None
        found = Found(baseline, baseline, hint=told)
        _, candidates = comparison.compared(baseline, forms(baseline.world), split, found)
        assert [one.cause for one in candidates] == causes
        assert all(one.merit > CONVINCING_NATS for one in candidates)
        assert found.left_out


@pytest.mark.slow
@pytest.mark.parametrize(
    ("beside", "alone"), [({}, True), ({"accelerometer.gravity_m_s2_per_rad": 5.0}, False)]
)
def test_only_what_came_near_elsewhere_is_fitted_where_that_leaves_nothing(
    beside: dict[str, float], alone: bool
) -> None:
    data, split = measured(SECONDS, 5, {"camera.rate_px_per_s": 0.1, **beside}), interleaved(SECONDS)
    baseline = fitted(data)
    both = [one for one in forms(baseline.world) if one.id in ("tracking_drift", "gravity_leakage")]
    _, there = comparison.compared(baseline, both, split, Found(baseline, baseline))
    drift = next(one for one in there if one.cause == "tracking_drift" and not one.form)
    other = replace(drift, cause="cubic_stiffness", form="", merit=0.1 * drift.merit)
    hint = Hint(baseline, Stage([], [drift, other], drift))
    screened, here = comparison.compared(baseline, both, split, Found(baseline, baseline, hint=hint))
    assert ("gravity_leakage" not in {one.cause.id for one in screened}) == alone
    told = [one.merit for one in here if one.cause == "cubic_stiffness"]
    assert told == ([pytest.approx(other.merit)] if alone else [])
