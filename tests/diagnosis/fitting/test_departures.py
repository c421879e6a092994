"""Where a fit departs from what was measured by far more than usual."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.diagnosis.fitting.departures import (
    as_loud_about,
    is_one_sided,
    loud_at,
    loud_stretch,
    sets_in_s,
    stretches,
)
from stillarm.diagnosis.fitting.fitted import Fit
from tests.fixtures.synthetic import fitted, measured

PERIOD_S = 1.0 / 2.6


@pytest.fixture(scope="module")
def arm() -> Fit:
    return fitted(measured(9.0, 3))


def with_more(arm: Fit, name: str, since_s: float, until_s: float, size: float) -> Fit:
    """A fit that leaves more between two instants."""
    time = arm.world.cycle_times if name == "acceleration" else arm.world.instants(arm.vector)
    more = np.where((time >= since_s) & (time < until_s), size * arm.sigma[name], 0.0)
    return replace(arm, residuals={**arm.residuals, name: arm.residuals[name] + more})


@pytest.mark.parametrize("name", ["acceleration", "displacement"])
def test_noise_is_not_loud(arm: Fit, name: str) -> None:
    found = loud_at(arm, name)
    assert found is not None and not found[1].any()


@pytest.mark.parametrize(
    ("flags", "found"),
    [([], []), ([0, 0], []), ([1, 1, 0, 1], [(0, 2), (3, 4)]), ([0, 1, 1, 0], [(1, 3)]), ([1], [(0, 1)])],
)
def test_runs_of_flags_are_told_by_their_ends(flags: list[int], found: list[tuple[int, int]]) -> None:
    assert stretches(np.array(flags, bool)) == found


def test_a_channel_that_was_not_measured_tells_nothing(arm: Fit) -> None:
    assert loud_at(arm, "deflection") is None


@settings(max_examples=25, deadline=None)
@given(st.floats(1.0, 7.0), st.floats(0.06, 0.5), st.floats(20.0, 200.0))
def test_a_loud_stretch_is_found_from_within_and_beside_it(
    arm: Fit, since_s: float, lasts_s: float, size: float
) -> None:
    found = loud_at(with_more(arm, "acceleration", since_s, since_s + lasts_s, size), "acceleration")
    assert found is not None
    for struck in (since_s, since_s + 0.5 * lasts_s, since_s + lasts_s + 0.1):
        span = loud_stretch(*found, struck, PERIOD_S)
        assert span is not None
        assert span[0] == pytest.approx(since_s, abs=0.011)
        assert span[1] == pytest.approx(since_s + lasts_s, abs=0.011)
    assert loud_stretch(*found, since_s - 0.4 * PERIOD_S, PERIOD_S) is None


def test_where_nothing_is_judged_a_stretch_is_not_over(arm: Fit) -> None:
    """As at the stroke in the middle of a push: the arm swings faster than a stroke is left out."""
    period_s = 0.1
    shaken = with_more(arm, "acceleration", 3.0, 3.1, 50.0)
    time = arm.world.cycle_times
    off = np.where((time > 3.03) & (time < 3.07), np.nan, shaken.residuals["acceleration"])
    found = loud_at(replace(shaken, residuals={**shaken.residuals, "acceleration": off}), "acceleration")
    assert found is not None
    assert loud_stretch(*found, 3.05, period_s) == pytest.approx((3.0, 3.1), abs=0.011)


@pytest.mark.parametrize("seed", range(5))
def test_what_stays_to_one_side_shows_below_the_noise_of_a_sample(seed: int) -> None:
    off = np.random.default_rng(seed).normal(size=2000)
    assert is_one_sided(off, 12).mean() < 0.01
    off[800:900] += 2.0  # as much in single samples is no rarity
    found = is_one_sided(off, 12)
    assert found[810:890].mean() > 0.9
    assert found[:780].mean() < 0.01 and found[920:].mean() < 0.01


def test_what_a_rest_becomes_louder_at_is_told_to_a_part_of_a_second_and_of_an_even_one_nothing() -> None:
    last = fitted(measured(12.0, 3))
    assert sets_in_s(last) == []
    off = last.residuals["acceleration"].copy()
    off[7400:] *= 3.0
    found = sets_in_s(replace(last, residuals={**last.residuals, "acceleration": off}))
    assert min(abs(one - 7.4) for one in found) < 0.1
    assert all(7.0 < one < 7.6 for one in found)


def test_what_sets_in_after_something_else_has_is_told_too() -> None:
    """A hum that is far louder than what an impact has left since."""
    last = fitted(measured(12.0, 3))
    off = last.residuals["acceleration"].copy()
    off[4400:] *= 10.0
    off[8100:] *= 10.0
    found = sets_in_s(replace(last, residuals={**last.residuals, "acceleration": off}))
    for there_s in (4.4, 8.1):
        assert min(abs(one - there_s) for one in found) < 0.1


def test_what_is_loud_for_long_after_is_not_as_loud(arm: Fit) -> None:
    """A wrong account of a push leaves ten times the usual for as long as the arm rings."""
    pushed = with_more(with_more(arm, "acceleration", 4.0, 4.3, 1000.0), "acceleration", 4.3, 7.0, 20.0)
    usual, most = loud_at(pushed, "acceleration"), as_loud_about(pushed, "acceleration", 4.1, PERIOD_S)
    assert usual is not None and most is not None
    usually = loud_stretch(*usual, 4.1, PERIOD_S)
    as_most = loud_stretch(*most, 4.1, PERIOD_S)
    assert usually is not None and usually[1] > 6.9
    assert as_most == pytest.approx((4.0, 4.3), abs=0.02)


def test_noise_is_not_as_loud_as_noise(arm: Fit) -> None:
    found = as_loud_about(arm, "acceleration", 4.1, PERIOD_S)
    assert found is not None and not found[1].any()
