"""The cycle that says a frame's delay, for methods that say it at once and for those that take some cycles."""

from stillarm.common.datagrams.visual_sample import TrackingStatus, VisualSample
from stillarm.controller.estimation.estimate import DelayEstimate, Estimate, FrameDelay, Status
from stillarm.controller.replay.frame_delays import FrameDelays

NOW = DelayEstimate(0.074, 0.001, Status.ESTIMATED)


def sample(frame: int) -> VisualSample:
    """A measured one."""
    return VisualSample(frame, 0, TrackingStatus.MEASURED, 0.0, 0.0, 0.0, 0.01)


def said(*dated: int, at_once: bool = False) -> Estimate:
    """What dates these frames; at_once: what dates all in their own cycle."""
    of_frames = tuple(
        FrameDelay(frame, DelayEstimate(0.001 * frame, 0.001, Status.ESTIMATED)) for frame in dated
    )
    return Estimate(NOW, dated=None if at_once else of_frames)


def places(told: list[tuple[int, DelayEstimate]]) -> list[tuple[int, float]]:
    """With the delays in ms."""
    return [(place, round(1e3 * delay.delay_s)) for place, delay in told]


def test_a_method_that_dates_at_once_says_each_delay_in_the_cycle_of_the_frame() -> None:
    """And never again."""
    delays = FrameDelays()
    assert places(delays.told([sample(7)], said(at_once=True))) == [(0, 74)]
    assert delays.told([], said(at_once=True)) == []
    assert places(delays.told([sample(8), sample(9)], said(at_once=True))) == [(1, 74), (2, 74)]


def test_a_frame_dated_later_is_told_once_more_and_once_only() -> None:
    """The frame's own number counts, not its place."""
    delays = FrameDelays()
    assert places(delays.told([sample(7)], said())) == [(0, 74)]
    assert delays.told([], said()) == []
    assert places(delays.told([], said(7))) == [(0, 7)]
    assert delays.told([], said(7)) == []


def test_images_that_had_to_wait_for_the_next_one_are_told_in_that_ones_cycle() -> None:
    """For example, when several images come close together."""
    delays = FrameDelays()
    assert places(delays.told([sample(7)], said())) == [(0, 74)]
    assert places(delays.told([sample(8), sample(9)], said(7, 8))) == [(1, 74), (2, 74), (0, 7), (1, 8)]
    assert places(delays.told([], said(9))) == [(2, 9)]
