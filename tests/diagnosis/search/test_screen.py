"""Score tests: what a baseline cannot explain at its bounds, and each form by its own trials."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.fitting.fitted import Fit, make_data
from stillarm.diagnosis.forms.cause import Trial
from stillarm.diagnosis.forms.causes.camera_clock_skew import CAUSE, FROM_AN_ONSET
from stillarm.diagnosis.physics.quantities import QUARTZ
from stillarm.diagnosis.search.begun import ground_of
from stillarm.diagnosis.search.screen import _scores, screen
from stillarm.diagnosis.search.whitened import Whitened
from tests.fixtures.synthetic import fitted, measured

SPLIT = interleaved(9.0)


def whitened(last: Fit) -> Whitened:
    return Whitened(make_data(last.world, SPLIT), last, ground_of(last, SPLIT).slopes)


def test_a_bound_that_the_baseline_came_to_is_no_direction() -> None:
    """The most that two sound clocks differ by is none of what a clock that runs fast gains."""
    last = fitted(measured(9.0, 3, {"timing.skew_ppm": 900.0}), split=SPLIT)
    assert last.value(QUARTZ) == last.world.space[QUARTZ].high
    found = screen(whitened(last), [CAUSE])
    assert max(one.nats for one in found) > 50.0


def test_no_form_hides_another_of_its_cause() -> None:
    last = fitted(measured(9.0, 3, {"timing.skew_ppm": 900.0}), split=SPLIT)
    found = screen(whitened(last), [CAUSE, FROM_AN_ONSET.cause])
    assert {id(one.cause) for one in found} == {id(CAUSE), id(FROM_AN_ONSET.cause)}


@pytest.mark.parametrize("channel", [1e200, np.inf, np.nan])
def test_a_trial_in_which_the_arm_runs_away_promises_nothing_and_warns_of_nothing(channel: float) -> None:
    last = fitted(measured(9.0, 3), split=SPLIT)
    white, start = whitened(last), last.vector
    base = last.predicted
    far = replace(base, channels={name: one + channel for name, one in base.channels.items()})
    trial = Trial({}, ({"camera.offset_px": 1.0},))

    class RunsAway:
        space, predict = last.world.space, staticmethod(lambda *_: far)

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert _scores(white, CAUSE, trial, (RunsAway(), start, base), ()) == []  # type: ignore[arg-type]
