"""Pulls, pushes, gaps and the busy computer are as the generator states."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stillarm.benchmarks.estimators.bound import bound
from stillarm.benchmarks.estimators.conditions_table import ConditionJob, condition_rows, withstand
from stillarm.benchmarks.estimators.starts import FIGURES, OPEN_STARTS, during_of
from stillarm.benchmarks.estimators.trial import Said, samples_by_cycle
from stillarm.benchmarks.estimators.world.generator import generate
from stillarm.benchmarks.estimators.world.regimes import REGIMES, Arm

LIVE = REGIMES["live"]


def test_the_bound_of_a_busy_computer_is_not_above_that_of_white_jitter() -> None:
    """The bound knows the waits."""
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
