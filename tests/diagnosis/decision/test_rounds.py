"""Which form stands for a cause in a round of the search. What a round takes: test_explain.py."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision import rounds
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import Fit, make_data
from stillarm.diagnosis.fitting.gains import free_names
from stillarm.diagnosis.forms.cause import Form
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.search.baseline import moved_as_measured
from stillarm.diagnosis.search.candidates import Candidate, Found, Stage
from tests.fixtures.synthetic import MODEL, measured

LAST = cast(Fit, SimpleNamespace())


def candidate(cause: str, form: str, merit: float) -> Candidate:
    return Candidate(cause, LAST, 0.0, 0.0, {}, form=form, merit=merit, nats=np.zeros(3))


@pytest.mark.parametrize(
    ("convincing", "expected"),
    [
        ({"straight", "walk", "other"}, [("delay_drift", "straight"), ("clock_step", "other")]),
        ({"walk", "other"}, [("clock_step", "other"), ("delay_drift", "walk")]),
        ({"course"}, [("clock_step", "other"), ("delay_drift", "course")]),
        (set(), [("delay_drift", "straight"), ("clock_step", "other")]),
    ],
)
def test_the_best_form_that_convinces_stands_for_its_cause(
    monkeypatch: pytest.MonkeyPatch, convincing: set[str], expected: list[tuple[str, str]]
) -> None:
    monkeypatch.setattr(rounds, "convinces", lambda one, *_: one.form in convincing)
    tried = [
        candidate("delay_drift", "course", 14.0),
        candidate("delay_drift", "straight", 40.0),
        candidate("clock_step", "other", 30.0),
        candidate("delay_drift", "walk", 17.0),
    ]
    best = rounds._best_that_convinces(tried, LAST, interleaved(20.0), beside=False)
    assert [(one.cause, one.form) for one in best] == expected


@pytest.mark.parametrize(
    ("merit", "left", "enough", "compared"),
    [
        (100.0, True, True, ["camera_clock_skew", "tracking_drift"]),
        (900.0, True, True, []),
        (100.0, True, False, ["camera_clock_skew", "tracking_drift", "mains_hum"]),
        (900.0, False, True, ["camera_clock_skew", "tracking_drift", "mains_hum"]),
    ],
)
def test_what_the_first_dwarfed_is_held_against_others_of_its_sensor(
    merit: float, left: bool, enough: bool, compared: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Stale frames that explain the rest beside a mode of 1000 nats: a clock that gained less was never fitted to its
    end. Where the mode left nothing that matters, they explain no rest. left: beside the mode, that matters."""
    last = cast(Fit, SimpleNamespace())
    monkeypatch.setattr(
        rounds, "anything_but_spikes_matters", lambda one, _: left if one is last else not enough
    )
    mode = candidate("second_bending_mode", "", 1000.0)
    found = Found(LAST, last, [mode], [Stage([], [mode], mode)])
    allowed = [
        cast(Form, SimpleNamespace(id=cause))
        for cause in ("camera_clock_skew", "tracking_drift", "mains_hum")
    ]
    anew = rounds._to_compare([candidate("stale_frame_buffer", "", merit)], allowed, found, interleaved(20.0))
    assert [one.id for one in anew] == compared


@pytest.mark.parametrize(
    ("little", "taken"),
    [
        (set(), "gravity_leakage"),
        ({"gravity_leakage"}, "clock_step"),
        ({"gravity_leakage", "clock_step"}, None),
    ],
)
def test_what_tells_little_hides_nothing_that_goes_wrong_elsewhere(
    little: set[str], taken: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A part of a bias that walks, which leads, and a clock that was set."""
    monkeypatch.setattr(rounds, "convinces", lambda one, *_: one.cause != "mains_hum")
    monkeypatch.setattr(rounds, "share_explained", lambda one, *_, **__: 0.1 if one.cause in little else 0.9)
    tried = [
        replace(candidate(cause, "", merit), gains={channel: merit})
        for cause, channel, merit in (
            ("gravity_leakage", "acceleration", 109.0),
            ("clock_step", "arrival", 64.0),
            ("mains_hum", "acceleration", 9.0),
        )
    ]
    found = Found(LAST, LAST, [candidate("accelerometer_bias_drift", "", 5000.0)])
    stage = Stage([], list(tried), tried[0])
    rounds._telling_enough(stage, found, interleaved(20.0))
    assert (stage.taken.cause if stage.taken is not None else None) == taken
    assert stage.candidates == tried


@pytest.mark.parametrize(
    ("first", "second", "leads"),
    [
        (("drive_deadband", 900.0), ("stiffness_drift", 4000.0), 1),
        (("drive_deadband", 4000.0), ("stiffness_drift", 900.0), 0),
        (("cubic_stiffness", 900.0), ("stiffness_drift", 4000.0), 0),
    ],
)
def test_what_tells_most_leads_whatever_the_drive_did(
    first: tuple[str, float], second: tuple[str, float], leads: int
) -> None:
    findings = [candidate(cause, "", merit) for cause, merit in (first, second)]
    assert rounds._largest_first(findings)[0] is findings[leads]


@pytest.mark.slow
def test_what_the_joint_tells_of_the_drive_leaves_the_arm_s_modes_as_they_were() -> None:
    """The model's frequency is a tenth off, which the joint's own channels cannot know: a fit to them alone has the
    model's, from which none to all channels leads back."""
    hz, dead_s, split = 1.1 * MODEL.arm.modes[0].frequency_hz, 0.03, interleaved(40.0)
    data = measured(40.0, 5, {"modes.0.frequency_hz": hz, "drive.dead_time_s": dead_s})
    world = moved_as_measured(World(data, MODEL), split)
    begun = world.space.with_values(world.space.vector(), {"modes.0.frequency_hz": hz})
    last = fit(make_data(world, split), begun, world.baseline_names())
    alone, own = rounds._joint_alone(last, split), ("drive.dead_time_s",)
    late = alone.world.space.with_values(alone.vector, {own[0]: dead_s})
    told = fit(make_data(alone.world, split), late, free_names(alone, alone.world, own))
    one = Candidate("drive_dead_time", told, 0.0, 0.0, {}, free=own)
    whole = rounds._of_the_whole(one, last, split).fit
    assert whole.value("modes.0.frequency_hz") == pytest.approx(hz, rel=1e-3)
    assert whole.value(own[0]) == pytest.approx(dead_s, abs=1e-3)
    assert np.nanstd(whole.residuals["displacement"]) < 1.1 * np.nanstd(last.residuals["displacement"])
