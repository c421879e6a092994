"""Random walks among the candidates: what they are held against, and what they stand for."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms import delay_walk, sensor_walk
from stillarm.diagnosis.forms.catalogue import forms
from stillarm.diagnosis.search import walks
from stillarm.diagnosis.search.candidates import Candidate, Found
from stillarm.diagnosis.search.comparison import compared
from stillarm.diagnosis.search.walks import walks_judged
from tests.fixtures.synthetic import fitted, measured

SPLIT = interleaved(20.0)


def test_a_walk_is_held_against_what_tells_of_its_channel_however_little_that_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A clock that was set foretells the arrivals, beside a drift of a sensor that is told in ten ways."""
    walk = delay_walk.FORM
    monkeypatch.setattr(walks, "_WALKS", ((walk, "arrival", lambda _, fit: fit.vector is not None),))
    nothing = cast(Fit, SimpleNamespace(vector=None))
    step = replace(nothing_but("clock_step", "arrival", 300.0), fit=cast(Fit, SimpleNamespace(vector=1)))
    louder = [replace(nothing_but(f"cause {i}", "acceleration", 5000.0), fit=nothing) for i in range(10)]
    wanders = replace(nothing_but(walk.id, "arrival", 390.0), form=walk.name)
    by_merit = [*louder, wanders, step]
    assert walks_judged(by_merit, nothing, [], SPLIT) == [*louder, step]
    assert walks_judged([*louder, wanders], nothing, [], SPLIT) == [*louder, wanders]


def nothing_but(cause: str, channel: str, merit: float) -> Candidate:
    """A candidate that tells something in one channel."""
    return Candidate(cause, cast(Fit, SimpleNamespace()), 0.0, 0.0, {}, merit=merit, gains={channel: merit})


@pytest.mark.slow
def test_tracking_that_strays_with_the_path_is_no_random_walk() -> None:
    """A walk goes anywhere; one number that foretells where it went is the better account, with its size."""
    data, split = measured(20.0, 1), interleaved(20.0)
    plain = fitted(data)
    seen = plain.predicted.channels["displacement"]
    strayed = 2e-4 * np.cumsum(np.abs(np.diff(seen, prepend=seen[0])))
    frames = replace(data.frames, displacement_px=data.frames.displacement_px + strayed)
    last = fitted(replace(data, frames=frames))
    drift = [one for one in forms(last.world) if one.id == "tracking_drift"]
    _, candidates = compared(last, drift, split, Found(last, last))
    assert candidates[0].form == "with the path travelled"
    assert "as a random walk" not in {one.form for one in candidates}
    rate, _ = candidates[0].values["rate_px_per_s"]
    assert rate == pytest.approx(strayed[-1] / 20.0, rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("known", [True, False])
def test_a_walk_takes_what_two_causes_foretell_together(known: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """A bias that drifts along a line, beside an axis that leans, if it is known to. The line is nearly enough here."""
    monkeypatch.setattr(walks, "_RIVALS", 0)
    values = {"accelerometer.rate_m_s3": 0.1, "accelerometer.gravity_m_s2_per_rad": 2.0}
    last = fitted(measured(20.0, 1, values))
    line = fitted(last.world.measured, "accelerometer.rate_m_s3")
    drifts = replace(nothing_but("accelerometer_bias_drift", "acceleration", 50.0), fit=line)
    wanders = replace(
        nothing_but(sensor_walk.BIAS_WALK.id, "acceleration", 300.0), form=sensor_walk.BIAS_WALK.name
    )
    leans = [one for one in forms(last.world) if one.id == "gravity_leakage"]
    kept = walks_judged([wanders, drifts], last, leans if known else [], SPLIT)
    assert kept == ([drifts] if known else [wanders, drifts])


@pytest.mark.slow
def test_a_large_walk_of_the_bias_is_no_course() -> None:
    """The log score makes more of a course of knots, which leaves as much as a cause of its own."""
    data = measured(20.0, 1)
    strayed = np.cumsum(np.random.default_rng(3).normal(0.0, 0.16, data.cycles))
    last = fitted(replace(data, acceleration=data.acceleration + strayed))
    walk = sensor_walk.walk_in(last, "acceleration")
    drift = [one for one in forms(last.world) if one.id == "accelerometer_bias_drift"]
    _, candidates = compared(last, drift, SPLIT, Found(last, last))
    assert walk is not None and candidates[0].merit > walk.nats
    assert candidates[0].form == "as a random walk"
    assert "along a course" not in {one.form for one in candidates}
