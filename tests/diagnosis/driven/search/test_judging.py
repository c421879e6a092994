"""What a form is worth: up to a frequency where there are impacts, and a late input against an amplifier's lag."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from stillarm.diagnosis.driven.fitting.fitting import DrivenFit, fit
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.mechanisms.mechanisms import AMPLIFIER_LAG, FORMS, STRUCTURE
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.recording.signals import Driven, Output
from stillarm.diagnosis.driven.search.judging import (
    AT_TOPS,
    CONVINCES,
    PRICE,
    Tried,
    gains,
    judged,
    lags_told,
    least_step,
    may_win,
)

STEP_S = 0.01
LATE = next(one for one in FORMS if "late" in one.numbers)
LAG = next(one for one in FORMS if one.words == AMPLIFIER_LAG)
LIMIT = next(one for one in FORMS if one.cause == AT_TOPS)
PLAY = next(one for one in FORMS if one.play)


def _fitted(delay_s: float = 0.0) -> DrivenFit:
    u = np.random.default_rng(1).standard_normal(900)
    seen = Output("joint_position_rad", "position", np.cumsum(np.cumsum(u)) * STEP_S**2, True, 0.0)
    driven = Driven("x", STEP_S, 0.0, "motor_voltage_v", u, True, (seen,), {})
    numbers = {
        "gain": 1.0,
        "damping": 0.0,
        "delay": delay_s,
        "offset joint_position_rad": 0.0,
        "gap": 1.0,
        "share": 0.4,
    }
    return fit(GreyBox(driven, irregular(9.0)), numbers, (), steps=0)


def test_play_is_judged_up_to_the_frequency_that_its_impacts_leave_alone() -> None:
    """Here it gains 10 nats in each of three low bands, and loses 900 above: other forms would be worth that."""
    before = _fitted().likeliest
    more = np.zeros_like(before.whole_bands)
    more[:, 1:4], more[:, -1] = 10.0, -900.0
    after = replace(before, whole_bands=before.whole_bands + more, held_bands=before.held_bands + more)
    blocks, bands = more.shape
    held = int(before.box.split.held.sum())
    assert gains(PLAY, after, before) == pytest.approx((30.0 * blocks - np.log(bands), 30.0 * held))
    assert gains(LAG, after, before)[0] == pytest.approx(-870.0 * blocks)
    none_at_all = replace(after, numbers={**after.numbers, "gap": 0.0})
    assert judged(PLAY, after, before).merit > 0.0 and judged(PLAY, none_at_all, before).merit == -np.inf


def _gained(before: DrivenFit, blocks: NDArray[np.bool_]) -> DrivenFit:
    """A fit that gains 10 nats in each of some blocks."""
    more = np.zeros_like(before.whole_bands)
    more[blocks, 1] = 10.0
    return replace(before, whole_bands=before.whole_bands + more, held_bands=before.held_bands + more)


def test_a_limit_that_acts_in_blocks_that_train_alone_is_not_disproven_by_the_others() -> None:
    """Any other form has to gain a third of its nats where it was held out."""
    before = _fitted().likeliest
    box = before.box
    trains = ~box.split.held
    highest = np.sort([np.max(np.abs(box.driven.u[box.block == k])) for k in np.flatnonzero(box.split.held)])[
        -1
    ]
    gained = _gained(before, trains)
    beyond = replace(gained, numbers={**before.numbers, "limit": float(highest)})
    assert judged(LIMIT, beyond, before).merit == pytest.approx(10.0 * trains.sum() - PRICE)
    everywhere = replace(gained, numbers={**before.numbers, "limit": 0.0})
    assert judged(LIMIT, everywhere, before).merit == pytest.approx(-PRICE)
    assert judged(LAG, gained, before).merit == pytest.approx(-PRICE)


def test_a_limit_that_acts_where_it_was_held_out_alone_says_nothing() -> None:
    """No sample that trains tells its value."""
    before = _fitted().likeliest
    box = before.box
    u = np.where(box.split.held[box.block], box.driven.u, 0.0)
    there = replace(before, box=replace(box, driven=replace(box.driven, u=u)))
    limit = 0.9 * float(np.max(np.abs(u)))
    gained = replace(_gained(there, box.split.held), numbers={**before.numbers, "limit": limit})
    assert judged(LIMIT, gained, there).merit == pytest.approx(-PRICE)


def test_a_late_input_is_a_cause_by_odds_against_an_amplifiers_lag() -> None:
    fitted = _fitted(0.05)
    lag = Tried(LAG, fitted, 60.0, 60.0)
    for merit, cause in ((60.0 + CONVINCES + 1.0, LATE.cause), (60.0 + CONVINCES - 1.0, STRUCTURE)):
        told = lags_told([lag, Tried(LATE, fitted, merit, merit)])
        assert [one.form.cause for one in told] == [STRUCTURE, cause]
    assert lags_told([Tried(LATE, fitted, 20.0, 20.0)])[0].form.cause == LATE.cause


def test_a_delay_that_the_plain_model_may_have_is_none() -> None:
    for delay_s, cause in ((0.014, STRUCTURE), (0.016, LATE.cause)):
        fitted = _fitted(delay_s)
        assert judged(LATE, fitted, fitted).form.cause == cause
        assert judged(LATE, fitted, fitted).merit == pytest.approx(-PRICE)


def test_a_late_sensor_says_nothing_without_odds_against_an_amplifiers_lag() -> None:
    """Where the other sensors are too coarse to tell, a lag of the one that tells is the amplifier's as well."""
    fitted = _fitted()
    late = replace(LATE, words="of joint_velocity_rad_s", numbers=("delay joint_velocity_rad_s",))
    lag = Tried(LAG, fitted, 60.0, 60.0)
    for merit, told in ((60.0 + CONVINCES + 1.0, 60.0 + CONVINCES + 1.0), (60.0 + CONVINCES - 1.0, -np.inf)):
        assert [one.merit for one in lags_told([lag, Tried(late, fitted, merit, merit)])] == [60.0, told]


def test_a_fit_is_given_up_by_what_the_best_gained_and_goes_on_near_it() -> None:
    fitted = _fitted()
    tried = [Tried(LAG, fitted, merit, 0.0) for merit in (-np.inf, 900.0, 20.0)]
    assert least_step(tried, 18) == pytest.approx(1.0)  # eighteen of them are 2 % of it
    assert least_step(tried[:1], 18) == 0.0
    given_up = replace(fitted, given_up=True)
    assert not may_win(Tried(LAG, fitted, 890.0, 0.0), 900.0)
    assert [may_win(Tried(LAG, given_up, merit, 0.0), 900.0) for merit in (870.0, 860.0)] == [True, False]
