"""Kills of the supervisor: the gap in the images, and the scores of the estimates after it."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.benchmarks.live.kills.kill_plan import Kill
from stillarm.benchmarks.live.kills.kill_scoring import gap_around, score_kill
from stillarm.benchmarks.live.scoring import Estimates
from tests.fixtures.live_rows import A, W, perfect, true_run

KILL = Kill(at_s=5.0, gap_s=1.0, until_s=10.0)
GAP = (4.99, 6.0)


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
    """The estimate is off by half the deflection and states 0.1 mm during the silence."""
    found = score_kill(said(5.0, 6.0, 0.5), true_run(), KILL, GAP)
    assert found["longest_beyond_2_std_s"] == pytest.approx(1.0, abs=0.2)
    assert found["settled_s"] == 0.0
    assert found["deflection_normalised_error_squared_max"] == pytest.approx(0.0, abs=1e-9)


def test_no_estimate_is_an_error_of_the_whole() -> None:
    right = perfect(true_run())
    silent = np.where((right.time_s >= 6.0) & (right.time_s < 7.5), np.nan, right.deflection_m)
    found = score_kill(replace(right, deflection_m=silent), true_run(), KILL, GAP)
    assert found["settled_s"] == pytest.approx(1.5, abs=0.3)
