"""Late arrivals tell nothing of the clock; one far earlier than all before it tells that those were late."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.controller.estimation.fused.dates.arrival_floor import ArrivalFloor

SPREAD_S = 0.0064


def test_a_queue_that_drains_lets_the_floor_fall() -> None:
    """Three frames are late by up to 0.1 s, then none: `fell` tells of each step, and the mean is the floor's."""
    floor = ArrivalFloor(SPREAD_S)
    fell = 0
    for late in (0.1, 0.08, 0.05, *([0.0] * 60)):
        floor.see(late)
        fell += floor.fell
    assert fell == 3
    assert abs(floor.mean_s) < 1e-9


def test_bursts_are_not_near_the_floor_and_move_nothing() -> None:
    floor = ArrivalFloor(SPREAD_S)
    near = [floor.see(0.08 if k % 10 == 9 else 0.0) for k in range(200)]
    assert near.count(False) == 20
    assert floor.mean_s == 0.0 and not floor.fell


def test_a_delay_that_has_grown_for_good_is_followed() -> None:
    """After the memory of the lower floor is over."""
    floor = ArrivalFloor(SPREAD_S)
    for late in [0.0] * 50 + [0.06] * 200:
        floor.see(late)
    assert floor.see(0.061)
    assert abs(floor.mean_s - 0.06) < 0.002


@settings(max_examples=50, derandomize=True)
@given(seed=st.integers(0, 10_000))
def test_an_even_spread_is_all_near(seed: int) -> None:
    """Gaussian arrivals of the stated spread: hardly any is left out, and the floor hardly falls."""
    random = np.random.default_rng(seed)
    floor = ArrivalFloor(SPREAD_S)
    near = fell = 0
    for late in SPREAD_S * random.standard_normal(500):
        near += floor.see(float(late))
        fell += floor.fell
    assert near >= 495
    assert fell <= 3
