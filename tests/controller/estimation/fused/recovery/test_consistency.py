"""Honest filters are left alone; those that err more than they say are doubted, and begin anew if it lasts."""

import numpy as np

from stillarm.controller.estimation.fused.recovery.consistency import Consistency

FRAME_S = 1.0 / 65.0


def test_an_honest_filter_is_not_doubted() -> None:
    """Ten minutes of normalised innovations squared as they should be."""
    random = np.random.default_rng(3)
    watch, doubted = Consistency(), 0
    for k in range(40_000):
        assert not watch.see(k * FRAME_S, float(random.standard_normal() ** 2), 5e-5, 6e-5, 0.074)
        doubted += watch.doubtful
    assert doubted < 40
    assert watch.factor == 1.0


def test_a_filter_that_is_too_sure_states_more_and_then_begins_anew() -> None:
    """Errors of three times what is said: doubted within half a second, the deviation raised by about so much."""
    random = np.random.default_rng(4)
    watch, told_at, lost_at = Consistency(), None, None
    watch.begin(0.0)
    for k in range(400):
        time_s = k * FRAME_S
        lost = watch.see(time_s, float((3.0 * random.standard_normal()) ** 2), 0.0, 6e-5, 0.074)
        told_at = time_s if told_at is None and watch.doubtful else told_at
        if lost:
            lost_at = time_s
            break
    assert told_at is not None and told_at < 0.5
    assert lost_at is not None and 3.0 <= lost_at < 4.0
    assert 1.8 < watch.factor < 4.0


def test_it_settles_again() -> None:
    watch = Consistency()
    for k in range(100):
        watch.see(k * FRAME_S, 20.0, 0.0, 6e-5, 0.074)
    assert watch.doubtful
    for k in range(100, 300):
        watch.see(k * FRAME_S, 1.0, 0.0, 6e-5, 0.074)
    assert not watch.doubtful and watch.factor == 1.0


def test_dates_that_cannot_be_are_doubted() -> None:
    """A quartz that is off by 0.1 %, and a frame that was read before it was exposed."""
    for skew, delay_s in ((1e-3, 0.074), (0.0, -0.001)):
        watch = Consistency()
        watch.see(0.0, 1.0, skew, 6e-5, delay_s)
        assert watch.doubtful


def test_it_is_proven_once_it_was_consistent_for_a_while() -> None:
    watch = Consistency()
    for k in range(20):
        watch.see(k * FRAME_S, 20.0, 0.0, 6e-5, 0.074)
    assert not watch.proven
    for k in range(20, 300):
        watch.see(k * FRAME_S, 1.0, 0.0, 6e-5, 0.074)
    assert watch.proven
    watch.see(300 * FRAME_S, 30.0, 0.0, 6e-5, 0.074)
    assert watch.proven  # what comes later is a force, or another arm
    watch.begin(5.0)
    assert not watch.proven
