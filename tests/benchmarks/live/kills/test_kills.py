"""Kills of the supervisor: when they come, which gap is theirs, and what is made of the estimates after it."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.benchmarks.live.kills.kill_plan import BEFORE_KILL_S, Kill, plan
from stillarm.benchmarks.live.kills.kill_scoring import gap_around, score_kill
from stillarm.benchmarks.live.kills.kill_tables import by_gap, verdict
from stillarm.benchmarks.live.scoring import Estimates
from tests.benchmarks.live.test_scoring import A, W, perfect, true_run

KILL = Kill(at_s=5.0, gap_s=1.0, until_s=10.0)
GAP = (4.99, 6.0)


def test_every_gap_comes_once_each_after_a_strike_of_its_own() -> None:
    gaps = [0.3, 1.0, 3.0, 10.0]
    kills, scenario = plan(gaps, 3)
    assert sorted(kill.gap_s for kill in kills) == gaps
    assert [kill.gap_s for kill in kills] != [kill.gap_s for kill in plan(gaps, 4)[0]]
    assert len(scenario.strikes) == 4 and not scenario.moves and not scenario.damping
    for strike, kill in zip(scenario.strikes, kills, strict=True):
        assert BEFORE_KILL_S <= kill.at_s - strike.time_s <= BEFORE_KILL_S + 0.4
    for kill, strike in zip(kills, scenario.strikes[1:], strict=False):
        assert kill.at_s + kill.gap_s + 3.5 < kill.until_s < strike.time_s
    assert kills[-1].until_s < scenario.duration_s


def test_the_gap_is_the_silence_that_begins_with_the_kill() -> None:
    """An image that was on its way is still read; so are those before it, at whatever distance."""
    received = [*np.arange(3.0, 5.06, 0.015).tolist(), *np.arange(6.2, 12.0, 0.015).tolist()]
    assert gap_around(KILL, received) == pytest.approx((5.055, 6.2))
    assert gap_around(KILL, [3.0]) is None


def said(from_s: float, until_s: float, share: float) -> Estimates:
    """Right but for a span, in which they are off by a share of the deflection."""
    right = perfect(true_run())
    t = right.time_s
    wrong = np.where((t >= from_s) & (t < until_s), (1.0 + share) * right.deflection_m, right.deflection_m)
    return replace(right, deflection_m=wrong)


def test_it_has_settled_when_the_error_stays_small() -> None:
    truth = true_run()
    assert score_kill(said(0.0, 0.0, 0.0), truth, KILL, GAP)["settled_s"] == 0.0
    assert score_kill(said(5.0, 6.8, 0.5), truth, KILL, GAP)["settled_s"] == pytest.approx(0.8, abs=0.3)
    late = score_kill(said(8.0, 8.5, 0.5), truth, KILL, GAP)  # right at first, and wrong again
    assert late["settled_s"] == pytest.approx(2.5, abs=0.3)
    assert late["error_max"] == pytest.approx(0.5, rel=0.1)


def test_what_comes_after_the_next_strike_counts_for_nothing() -> None:
    found = score_kill(said(10.0, 20.0, 5.0), true_run(), KILL, GAP)
    assert found["settled_s"] == 0.0
    assert found["error_max"] == pytest.approx(0.0, abs=1e-9)
    assert found["amplitude_m"] == pytest.approx(A * np.exp(-0.01 * W * 4.0), rel=0.05)


def test_being_wrong_and_sure_counts_from_the_kill_on() -> None:
    """Half the deflection off, with a stated deviation of 0.1 mm: sure of it in the silence."""
    found = score_kill(said(5.0, 6.0, 0.5), true_run(), KILL, GAP)
    assert found["longest_beyond_2_std_s"] == pytest.approx(1.0, abs=0.2)
    assert found["settled_s"] == 0.0
    assert found["deflection_normalised_error_squared_max"] == pytest.approx(0.0, abs=1e-9)


def test_no_estimate_is_an_error_of_the_whole() -> None:
    right = perfect(true_run())
    silent = np.where((right.time_s >= 6.0) & (right.time_s < 7.5), np.nan, right.deflection_m)
    found = score_kill(replace(right, deflection_m=silent), true_run(), KILL, GAP)
    assert found["settled_s"] == pytest.approx(1.5, abs=0.3)


def test_tables_count_the_kills_of_each_gap_and_judge_them() -> None:
    rows = [
        {"method": "fused", "gap_asked_s": gap, "gap_s": gap + 0.1, "settled_s": settled, "error_mean": 0.01,
         "error_max": 0.03, "amplitude_m": 0.002, "delay_normalised_error_squared_max": 1.0,
         "deflection_normalised_error_squared_max": honest, "longest_beyond_2_std_s": 0.1}
        for gap, settled, honest in ((0.3, 0.5, 1.0), (0.3, 1.2, 4.0), (3.0, None, None))
    ]  # fmt: skip
    first, second = by_gap(rows)
    assert (first["kills"], first["within 1 s"], first["worst"]) == (2, 1, "1.20")
    assert first["gap, s"] == "0.40 to 0.40"
    assert (second["kills"], second["within 1 s"], second["settled, s"]) == (1, 0, "-")
    assert [row["kept after"] for row in verdict(rows)] == ["1 of 3 kills", "2 of 3 kills", "3 of 3 kills"]
