"""The filter that starts at an impact replaces the other on evidence only."""

from math import nan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.controller.estimation.kalman.belief import Belief
from stillarm.controller.estimation.kalman.rival import Rival


def said(time_s: float, log_density: float) -> Belief:
    """A belief whose last image was foretold so well."""
    return Belief(time_s, np.zeros(2), np.eye(2), False, log_density)


def watch(mine: list[float], others: list[float], step_s: float = 0.015) -> Rival:
    """Settled after 0.2 s, watched for 0.4 s, images `step_s` apart, until it is decided."""
    rival = Rival(said(0.0, nan), 0, 0.2, 0.4)
    for k, (a, b) in enumerate(zip(mine, others, strict=True), start=1):
        rival.see(said(k * step_s, a), said(k * step_s, b))
        if rival.decided:
            break
    return rival


@given(st.lists(st.floats(-40.0, 8.0), min_size=60, max_size=60))
@settings(deadline=None)
def test_nobody_wins_by_foretelling_the_same(densities: list[float]) -> None:
    """The comparison ends when its time is over, and the incumbent remains."""
    rival = watch(densities, densities)
    assert rival.decided
    assert not rival.wins


def test_it_wins_by_steady_evidence_and_the_sooner_the_clearer() -> None:
    """Half a nat an image is enough by the end; ten are enough after the least number of images."""
    steady = watch([2.0] * 60, [1.5] * 60)
    assert steady.wins
    assert steady.belief.time_s == pytest.approx(0.6, abs=0.016)
    clear = watch([2.0] * 60, [-8.0] * 60)
    assert clear.wins
    assert clear.belief.time_s == pytest.approx(0.2 + 6 * 0.015, abs=0.031)


def test_what_it_says_before_it_has_settled_does_not_count() -> None:
    """It knows nothing then: neither for it nor against it."""
    assert not watch([50.0] * 12 + [1.0] * 48, [1.0] * 60).wins
    assert watch([-50.0] * 12 + [2.0] * 48, [1.0] * 60).wins


def test_one_outlier_does_not_decide() -> None:
    """Few images do not decide either, even over a long time."""
    others = [1.0] * 60
    others[20] = -1e6
    rival = watch([0.8] * 60, others)
    assert rival.decided
    assert watch([2.0] * 4, [1.0] * 4, step_s=0.3).decided is False
