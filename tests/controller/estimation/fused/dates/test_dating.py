"""Nominal instants: counters that jump, stalls, lost frames, stamps."""

from math import nan

import pytest

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.controller.estimation.fused.dates.dating import Dating
from stillarm.controller.estimation.fused.filters.laws import Law

FRAME_S = 1.0 / 65.0


def frame(number: int, captured_s: float = nan) -> VisualSample:
    return VisualSample(number, 0, 0, 1.0, captured_s=captured_s)


def test_frames_are_counted_by_the_counter_and_a_reset_by_the_time_passed() -> None:
    """Lost frames by the counter's jump; a counter that falls to zero by the clock; old frames not at all."""
    dating = Dating(FRAME_S, 0.074)
    assert dating.accept(frame(100), 1.0)
    assert dating.accept(frame(103), 1.0 + 3 * FRAME_S)
    assert dating.nominal[Law.CLOCK] == pytest.approx(0.926 + 3 * FRAME_S)
    assert dating.doubt_s == 0.0
    assert not dating.accept(frame(103), 1.0 + 3.1 * FRAME_S)
    assert not dating.accept(frame(101), 1.0 + 3.2 * FRAME_S)
    assert dating.accept(frame(0), 1.0 + 5.1 * FRAME_S)
    assert dating.nominal[Law.CLOCK] == pytest.approx(0.926 + 5 * FRAME_S)
    assert dating.doubt_s > 0.0


def test_a_frame_that_is_very_late_by_chance_is_no_jump_of_the_counter() -> None:
    """40 ms after the others, with those behind it at once: known for it where the delay spreads by 6.4 ms."""
    dating = Dating(FRAME_S, 0.074, 0.0064)
    assert dating.accept(frame(0), 1.0)
    assert dating.accept(frame(1), 1.0 + FRAME_S + 0.040)
    assert dating.accept(frame(2), 1.0 + FRAME_S + 0.041)
    assert dating.nominal[Law.CLOCK] == pytest.approx(0.926 + 2 * FRAME_S)
    for more in range(4):  # six were lost, as the next three tell, which come in their own time
        assert dating.accept(frame(3 + more), 1.0 + FRAME_S + 0.041 + (6 + more) * FRAME_S)
    assert dating.nominal[Law.CLOCK] == pytest.approx(0.926 + 11 * FRAME_S)
    assert dating.doubt_s > 0.0


def test_a_stall_is_no_loss() -> None:
    """Six frames' time late, its successors in a burst: all were there, and only waited."""
    dating = Dating(FRAME_S, 0.074, 0.0064)
    for k in range(10):
        assert dating.accept(frame(k), 1.0 + k * FRAME_S)
    for k in range(10, 18):
        assert dating.accept(frame(k), 1.0 + 17 * FRAME_S + 0.001 * (k - 10))
    for k in range(18, 30):
        assert dating.accept(frame(k), 1.0 + k * FRAME_S)
    assert dating.nominal[Law.CLOCK] == pytest.approx(0.926 + 29 * FRAME_S)


def test_stamps_that_jump_are_doubted() -> None:
    """A step of the camera's clock does not move the frames by itself."""
    dating = Dating(FRAME_S, 0.074)
    for k in range(3):
        dating.accept(frame(k, 50.0 + k * FRAME_S), 1.0 + k * FRAME_S)
    before = float(dating.nominal[Law.STAMPS])
    assert dating.stamped
    dating.accept(frame(3, 90.0), 1.0 + 3 * FRAME_S)
    assert dating.stamp_doubt_s > 0.0
    assert dating.nominal[Law.STAMPS] - before == pytest.approx(FRAME_S)
