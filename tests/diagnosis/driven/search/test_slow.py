"""Torques that are slower than a block: longer blocks show what short ones lose to their own states."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.data.split import Split, stated
from stillarm.diagnosis.driven.fitting.fitting import DrivenFit, fit
from stillarm.diagnosis.driven.mechanisms.mechanisms import FORMS
from stillarm.diagnosis.driven.recording.blocks import irregular, longer
from stillarm.diagnosis.driven.recording.signals import Driven, Output
from stillarm.diagnosis.driven.search.judging import CONVINCES, Tried
from stillarm.diagnosis.driven.search.search import Round, Searched, tried_forms
from stillarm.diagnosis.driven.search.slow import with_slow_torques
from stillarm.diagnosis.driven.starts.start import linear_start

STEP_S, SAMPLES, FINE = 0.02, 1500, 20
GAIN, DAMPING = 6.0, 5.0  # a joint that stops within 0.2 s


def _start(gravity: float, offset: float = 0.0, split: Split | None = None) -> DrivenFit:
    """The linear start on the angle alone: theta'' = gain u - d theta' - gravity sin(theta) + offset."""
    generator = np.random.default_rng(3)
    t = np.arange(SAMPLES) * STEP_S
    u = sum(np.sin(2.0 * np.pi * hz * t + generator.uniform(0.0, 6.28)) for hz in np.arange(0.1, 2.0, 0.21))
    theta, omega, h = 0.0, 0.0, STEP_S / FINE
    angle = np.empty(SAMPLES)
    for k in range(SAMPLES):
        angle[k] = theta
        for _ in range(FINE):
            omega += h * (GAIN * u[k] - DAMPING * omega - gravity * np.sin(theta) + offset)
            theta += h * omega
    angle += 3e-3 * generator.standard_normal(SAMPLES)
    seen = Output("joint_position_rad", "position", angle, True, 0.0)
    driven = Driven("x", STEP_S, 0.0, "motor_voltage_v", np.asarray(u), True, (seen,), {})
    return linear_start(driven, split or irregular(driven.duration_s))


def _searched(start: DrivenFit) -> Searched:
    return Searched(start, (), start, (), ())


@pytest.mark.slow
def test_gravity_that_short_blocks_lose_shows_on_longer_ones() -> None:
    start = _start(0.01)
    short = [one.merit for one in tried_forms(start, lambda: 1e9) if one.form.cause == "gravity_load"]
    assert max(short) < CONVINCES
    found = with_slow_torques(_searched(start))
    assert found.rounds[0].taken.form.cause == "gravity_load"
    assert found.final.numbers["gravity_sine"] < 0.0  # it pulls back
    assert abs(found.final.numbers["gravity_sine"] + 0.01) < 3e-3


@pytest.mark.slow
def test_a_constant_torque_is_told_from_gravity_and_nothing_from_nothing() -> None:
    found = with_slow_torques(_searched(_start(0.0, 0.02)))
    assert [one.taken.form.cause for one in found.rounds] == ["torque_offset"]
    nothing = _searched(_start(0.0))
    assert with_slow_torques(nothing) is nothing


@pytest.mark.slow
@pytest.mark.parametrize(("worth", "cause"), [(1e6, "torque_ripple"), (CONVINCES, "gravity_load")])
def test_long_blocks_do_not_lose_a_cause_that_was_worth_more(worth: float, cause: str) -> None:
    """Here they have no use for a ripple, as they may not where a fit over them has ended beside it."""
    start = _start(0.01)
    ripple = next(one for one in FORMS if one.cause == "torque_ripple")
    begun = {**start.numbers, "ripple_cycles": 40.0, "ripple_sine": 1e-3, "ripple_cosine": 0.0}
    final = fit(start.box, begun, (*start.free, *ripple.numbers), start.states)
    taken = Round(start, (Tried(ripple, final, worth, worth),))
    found = with_slow_torques(Searched(start, (taken,), final, (), ()))
    assert found.rounds[-1].taken.form.cause == cause


def test_what_somebody_holds_out_stays_so() -> None:
    split = stated([(10.0, 15.0)], 0.0, SAMPLES * STEP_S)
    assert longer(split) is None
    found = _searched(_start(0.01, split=split))
    assert with_slow_torques(found) is found


def test_long_blocks_span_the_recording_and_hold_a_third_out() -> None:
    own = irregular(30.0)
    split = longer(own)
    assert split is not None
    assert split.edges_s[0] == 0.0 and split.edges_s[-1] == 30.0
    assert 3 * split.held.sum() == len(split.held) < len(own.held) and not split.held[0]
    assert longer(replace(own, held=~own.held)) is None
