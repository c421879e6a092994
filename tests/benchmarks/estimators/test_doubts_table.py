"""The fourth table: what is judged, in which cycles, and what the best of the others is."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.benchmarks.estimators import doubts_table
from stillarm.benchmarks.estimators.doubts_table import (
    BEST,
    Doubted,
    DoubtJob,
    Told,
    doubt,
    doubt_rows,
    told_in,
)
from stillarm.benchmarks.estimators.starts import OPEN_STARTS
from stillarm.benchmarks.estimators.trial import Answers
from stillarm.benchmarks.estimators.world.generator import Data, generate
from stillarm.benchmarks.estimators.world.regimes import REGIMES, Arm

JOB = DoubtJob("start while swinging", "live", 0, 3, ("correlation", "fused"))


def off_by(data: Data, error_m: float, std_m: float, trust: str) -> Answers:
    """Off by error_m in each cycle but the first ten, in which nothing is said."""
    said = data.deflection_m + error_m
    said[:10] = np.nan
    cycles, frames = len(said), len(data.frames.number)
    return Answers(
        said, np.full(cycles, std_m), np.zeros(frames), np.ones(frames), np.zeros(cycles), np.full(cycles, trust)
    )  # fmt: skip


def test_an_error_is_a_share_of_the_nominal_amplitude_and_no_answer_a_prediction_of_zero() -> None:
    data = generate(REGIMES["live"], 0.3, (1,), 5.0, Arm())
    unit = data.arm.amplitude_m
    cycles = np.zeros(len(data.deflection_m), np.bool_)
    cycles[:30] = True
    told = told_in(data, off_by(data, 0.1 * unit, 0.05 * unit, "settled"), cycles)
    assert (told.cycles, told.unanswered, told.stated) == (30, 10, 20)
    assert told.error == pytest.approx(20 * 0.1 + np.abs(data.deflection_m[:10]).sum() / unit)
    assert told.squared == pytest.approx(20 * 4.0)


def test_the_best_of_the_others_is_chosen_in_each_trial_and_never_fused() -> None:
    def told(error: float) -> Told:
        return Told(100, error, 100.0, 100, 0)

    trials = [
        Doubted(JOB, {"doubtful": {"fused": told(1.0), "a": told(4.0), "b": told(2.0)}}),
        Doubted(JOB, {"doubtful": {"fused": told(3.0), "a": told(2.0), "b": told(8.0)}}),
        Doubted(JOB, {}),
    ]
    rows = {row["method"]: row for row in doubt_rows(trials)}
    assert {row["trust"] for row in rows.values()} == {"doubtful"}
    assert [rows[name]["error_mean"] for name in ("fused", "a", "b", BEST)] == pytest.approx(
        [0.02, 0.03, 0.05, 0.02]
    )
    assert [rows[name]["better_than_fused"] for name in ("fused", "a", "b", BEST)] == [0.0, 0.5, 0.0, 0.5]
    assert rows[BEST]["trials"] == 2


def test_a_start_has_rows_of_its_words(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(OPEN_STARTS, JOB.condition, replace(OPEN_STARTS[JOB.condition], duration_s=4.0))
    doubted = doubt(JOB)
    assert {"starting", "settled"} <= set(doubted.told)
    rows = doubt_rows([doubted])
    settled = {row["method"]: row for row in rows if row["trust"] == "settled"}
    assert set(settled) == {"fused", "correlation", BEST}
    assert settled["fused"]["error_mean"] < settled["correlation"]["error_mean"]
    told = doubted.told
    cycles = sum(of_word["fused"].cycles for of_word in told.values())
    assert 3000 < cycles <= 4000
    assert tuple(OPEN_STARTS) == doubts_table.DOUBTED
