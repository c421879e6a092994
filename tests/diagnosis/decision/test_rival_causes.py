"""Which causes a finding is told apart from."""

from dataclasses import replace
from typing import cast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision.rival_causes import beside_what_followed, class_of, runner_up
from stillarm.diagnosis.fitting.evidence import score
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.physics.computing import limited
from stillarm.diagnosis.search.candidates import Candidate, Found, Stage
from tests.fixtures.candidates import bare_candidate
from tests.fixtures.synthetic import fitted, measured

SPLIT = interleaved(20.0)


def _found(*merits: tuple[str, float]) -> Found:
    candidates = [bare_candidate(cause, merit) for cause, merit in merits]
    found = Found(cast(Fit, None), cast(Fit, None), [candidates[0]])
    found.stages.append(Stage([], candidates, candidates[0]))
    return found


def test_a_rival_far_behind_is_told_apart() -> None:
    found = _found(("drive_lag", 500.0), ("drive_dead_time", 400.0))
    assert class_of(found, found.findings[0]) == []


def test_a_rival_within_odds_of_twenty_to_one_is_of_the_class() -> None:
    found = _found(("drive_lag", 50.0), ("drive_dead_time", 48.0))
    assert class_of(found, found.findings[0]) == ["drive_dead_time"]


def test_what_shows_in_another_channel_is_no_rival() -> None:
    clock, mode = (
        bare_candidate("clock_step", 300.0, "arrival"),
        bare_candidate("second_bending_mode", 600.0, "acceleration"),
    )
    found = Found(cast(Fit, None), cast(Fit, None), [clock])
    found.stages.append(Stage([], [mode, clock], clock))
    assert class_of(found, clock) == []
    assert runner_up(found, clock) is None


@given(first=st.floats(20.0, 1e5), behind=st.floats(0.0, 1.0))
def test_the_class_grows_as_the_odds_fall(first: float, behind: float) -> None:
    found = _found(("drive_lag", first), ("drive_dead_time", first * (1.0 - behind)))
    near = class_of(found, found.findings[0])
    if first * behind > max(3.0, 0.02 * first) + 1e-9:
        assert near == []


@pytest.mark.slow
def test_rivals_are_held_against_a_finding_beside_what_was_found_after_it() -> None:
    """A tracker that drifts, and a camera that turns with the joint. Two causes tied with the first while the camera
    was untold: one that says the same still does, one that told no more than the camera is told apart."""
    turns, drifts = "camera.rotation_px_per_rad", "camera.rate_px_per_s"
    data = measured(20.0, 3, {turns: 60.0, drifts: 0.6})
    base, final = fitted(data, split=SPLIT), fitted(data, turns, drifts, split=SPLIT)
    first = _taken("tracking_drift", fitted(data, drifts, split=SPLIT), base, drifts)
    same = replace(first, cause="lens_distortion")
    turned = _taken("camera_tilt_coupling", fitted(data, turns, split=SPLIT), base, turns)
    turned = replace(turned, nats=first.nats, merit=first.merit, gains=first.gains)
    second = _taken("camera_tilt_coupling", final, first.fit, turns)
    found = Found(base, final, [first, second])
    found.stages += [Stage([], [first, same, turned], first), Stage([], [second], second)]
    assert class_of(found, first) == ["lens_distortion", "camera_tilt_coupling"]

    with limited(0.0, lambda: 1.0):  # without time they stay as they were
        beside_what_followed(found, SPLIT)
    assert class_of(found, first) == ["lens_distortion", "camera_tilt_coupling"]

    beside_what_followed(found, SPLIT)

    assert class_of(found, first) == ["lens_distortion"]
    _, same, turned = found.stages[0].candidates
    assert same.merit == pytest.approx(first.merit, abs=3.0)
    assert turned.merit < 0.1 * first.merit


def _taken(cause: str, found: Fit, before: Fit, name: str) -> Candidate:
    after, base = score(found, SPLIT), score(before, SPLIT)
    nats = after.gain(base)
    gains = after.gains(base)
    return Candidate(
        cause, found, 1.0, 1.0, {}, free=(name,), merit=float(nats.sum()) - 3.0, nats=nats, gains=gains
    )
