"""Pulls, pushes, gaps and the busy computer: what the generator says of them must be true."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stillarm.benchmarks.estimators.bound import bound
from stillarm.benchmarks.estimators.conditions_table import ConditionJob, condition_rows, withstand
from stillarm.benchmarks.estimators.starts import FIGURES, OPEN_STARTS, during_of
from stillarm.benchmarks.estimators.trial import Said, samples_by_cycle, scored_cycles, swinging_cycles
from stillarm.benchmarks.estimators.world.excitation import (
    FIRST_S,
    pulled_slowly_at,
    pushed_again,
    released_again,
    struck_once,
)
from stillarm.benchmarks.estimators.world.generator import Excitation, Motion, expose, generate
from stillarm.benchmarks.estimators.world.regimes import CYCLE_S, FRAME_S, REGIMES, Arm, Busy

LIVE = REGIMES["live"]
BUSY = LIVE.busy or Busy()
EXCITATIONS = [released_again, pushed_again, struck_once, pulled_slowly_at(7.0)]


def drawn(excite: Excitation, seed: int) -> Motion:
    """A motion of 12 s."""
    return excite(Arm(), 12.0, np.random.default_rng(seed))


@pytest.mark.parametrize("excite", EXCITATIONS)
@pytest.mark.parametrize("seed", range(4))
def test_the_motion_obeys_the_modes_equation_under_a_hand(excite: Excitation, seed: int) -> None:
    """q' is the slope of q, q'' that of q'; q'' + 2 zeta w q' + w^2 q is the force; no jumps; the force as told."""
    arm, motion, h = Arm(), drawn(excite, seed), 1e-5
    time = np.linspace(0.01, 12.0, 3000)
    time = time[np.min(np.abs(time[:, None] - motion.start_s[None, :]), axis=1) > 3 * h]
    q, v, a = motion.at(time)
    before, after = motion.at(time - h), motion.at(time + h)
    assert (after[0] - before[0]) / (2 * h) == pytest.approx(v, abs=1e-6)
    assert (after[1] - before[1]) / (2 * h) == pytest.approx(a, abs=1e-3)
    w, row = arm.angular_frequency, motion.piece_at(time)
    force = motion.force_m_s2[row] + motion.force_rate_m_s3[row] * (time - motion.start_s[row])
    assert a + 2 * arm.damping_ratio * w * v + w**2 * q == pytest.approx(force, abs=1e-9)
    for start in motion.start_s[1:]:
        left, right = motion.at(np.array([start - 1e-9])), motion.at(np.array([start + 1e-9]))
        assert left[0] == pytest.approx(right[0], abs=1e-8)
        assert left[1] == pytest.approx(right[1], abs=1e-6)


def test_a_held_arm_is_seen_bent_and_felt_still() -> None:
    """Before the release: images show force / w^2, the accelerometer next to nothing; after it w^2 times as much."""
    arm = Arm()
    for seed in range(8):
        motion = drawn(released_again, seed)
        let_go = motion.forced_s[0, 1]
        held, free = motion.at(np.array([let_go - 0.01])), motion.at(np.array([let_go + 0.001]))
        bent = abs(held[0][0]) / arm.amplitude_m
        assert 0.8 < bent < 1.7
        assert abs(held[2][0]) < 0.2 * bent * arm.angular_frequency**2 * arm.amplitude_m
        assert free[2][0] == pytest.approx(-(arm.angular_frequency**2) * held[0][0], rel=0.1)
        ringing = motion.at(let_go + np.linspace(0.0, 1.0, 500))
        assert np.hypot(ringing[0], ringing[1] / arm.angular_frequency)[-1] > 0.6 * bent * arm.amplitude_m


@pytest.mark.parametrize("excite", [released_again, pushed_again, struck_once])
def test_an_arm_at_rest_stays_so_until_it_is_touched(excite: Excitation) -> None:
    """Rest is not scored, nor is a hand's force; what rings after either is."""
    data = generate(REGIMES["freerun drift"], 0.3, (3,), 12.0, Arm(), None, excite)
    first, end = data.motion.forced_s[0]
    assert first >= FIRST_S
    assert np.all(data.amplitude_m[: int(first / CYCLE_S)] == 0.0)
    scored = scored_cycles(data)
    assert not scored[: int((end + 0.49) / CYCLE_S)].any()
    assert scored[int((end + 0.52) / CYCLE_S) :][:1000].all()
    assert np.all(data.amplitude_m[swinging_cycles(data, 0.0)] > 0.0)


def test_the_slow_pull_leaves_what_was_before_as_it_was() -> None:
    """Blows as usual until a second before."""
    data = generate(REGIMES["freerun drift"], 0.3, (3,), 16.0, Arm(), None, pulled_slowly_at(9.0))
    pull = data.motion.forced_s
    assert pull.shape == (1, 2)
    assert pull[0, 0] == 9.0
    assert 3.0 < pull[0, 1] - 9.0 < 6.1
    assert len(data.motion.impacts_s) >= 3
    assert np.all(data.motion.impacts_s[:-1] < 8.1)


def test_a_busy_computer_is_behind_at_first_and_late_on_one_side_ever_after() -> None:
    """The start drains; then a hard earliest moment, a mean as told and a tail; n_i is when an earlier image ended."""
    late, first, means, lost = [], [], [], 0
    for seed in range(30):
        frames = expose(LIVE, 40.0, np.random.default_rng(seed))
        delay = frames.delay_s
        assert np.all(np.diff(frames.read_cycle) >= 0)
        assert delay.min() >= BUSY.earliest_s + BUSY.service_s
        first.append(delay[:8].mean())
        means.append(np.median(delay[80:]))
        late.append(delay[80:] - np.median(delay[80:]))
        lost += int(np.sum(np.diff(frames.number) - 1))
        begun = frames.started_cycle[BUSY.in_flight :]
        ended = frames.read_cycle[: -BUSY.in_flight]
        assert np.all((ended - begun >= 0) & (ended - begun <= 1))
        assert np.diff(frames.exposed_s) / np.diff(frames.number) == pytest.approx(FRAME_S, rel=2e-4)
    assert np.mean(np.array(first) > np.array(means) + 0.01) > 0.9
    assert 0.115 < np.mean(first) < 0.16
    assert np.mean(means) == pytest.approx(LIVE.delay_s, abs=0.003)
    assert np.std(means) == pytest.approx(BUSY.mean_std_s, rel=0.45)
    together = np.concatenate(late)
    assert np.quantile(together, 0.999) > 3.0 * -np.quantile(together, 0.001)
    assert lost < 200


def test_the_bound_of_a_busy_computer_is_not_above_that_of_white_jitter() -> None:
    """It is told the waits."""
    live = generate(LIVE, 0.3, (1,), 12.0, Arm())
    limit = bound(live).delay_std_s
    assert np.all(np.isfinite(limit))
    jitter = bound(generate(REGIMES["freerun jitter"], 0.3, (1,), 12.0, Arm())).delay_std_s
    assert limit[-1] < 1.5 * jitter[-1]


def test_a_gap_takes_images_and_a_restart_their_zero() -> None:
    """Nothing else changes; the new supervisor counts from 0 and says that it is new."""
    data = generate(REGIMES["freerun drift"], 0.3, (2,), 27.6, Arm())
    random = np.random.default_rng(1)
    for name, lasts in (("images gap 0.3 s", 0.3), ("images gap 10 s", 10.0)):
        left = OPEN_STARTS[name].change_data(data, random)
        assert len(data.seen_m) - len(left.seen_m) == pytest.approx(65 * lasts, abs=1)
        assert not any(sample.restarted for group in samples_by_cycle(left).values() for sample in group)
    anew = OPEN_STARTS["supervisor restarted"].change_data(data, random)
    samples = [sample for _, group in sorted(samples_by_cycle(anew).items()) for sample in group]
    marked = [sample for sample in samples if sample.restarted]
    assert [sample.frame for sample in marked] == [0]
    assert marked[0].displacement_x_px == 0.0
    assert len(anew.seen_m) == len(samples)
    dead = OPEN_STARTS["accelerometer dead from the start"].change_data(data, random)
    assert np.isnan(dead.acceleration_m_s2).all()


def test_figures_of_the_time_in_question_are_of_that_time() -> None:
    """An error outside it does not count; no answer counts as a prediction of zero."""
    count = np.arange(100)
    said = Said(
        np.full(100, 0.02), np.where(count < 50, 0.03, 0.9), np.full(100, 0.005), np.full(100, 1.0),
        np.full(10, 0.002), np.full(10, 0.001),
    )  # fmt: skip
    begun = during_of(said, count < 50, np.arange(10) < 3, 0.1)
    assert begun.error_mean_during == pytest.approx(0.1)
    assert begun.deflection_normalised_error_squared_during == pytest.approx(4.0)
    assert begun.delay_normalised_error_squared_during == pytest.approx(4.0)
    mute = during_of(replace(said, predicted_m=np.full(100, np.nan)), count < 50, np.zeros(10, np.bool_), 0.1)
    assert mute.unanswered_during == 1.0
    assert mute.error_mean_during == pytest.approx(0.2)
    assert np.isnan(mute.delay_normalised_error_squared_during)


def test_every_start_has_its_row(monkeypatch: pytest.MonkeyPatch) -> None:
    """With figures of its own, of which none needs what is not JSON; a short trial of each kind."""
    short: dict[str, Any] = {"release": 9.0, "images gap 0.3 s": 18.0, "supervisor restarted": 20.0}
    for name, lasts in short.items():
        monkeypatch.setitem(OPEN_STARTS, name, replace(OPEN_STARTS[name], duration_s=lasts))
    done = [
        withstand(ConditionJob(name, "live", 0, 0, ("timestamps",)))
        for name in (*short, "first swing from rest", "first motion of the joint")
    ]
    rows = {row["condition"]: row for row in condition_rows(done)}
    for name, row in rows.items():
        assert row["failure"] is None, name
        assert set(row) >= set(FIGURES)
        assert 0.0 < row["error_mean_during"] < 3.0
        assert 0.0 < row["error_mean"] < 1.0
    assert rows["images gap 0.3 s"]["error_mean_during"] < 0.5
    json.dumps(list(rows.values()), allow_nan=False)
