"""Offset, skew and round trip against simulated clocks and ways that the estimator knows nothing of."""

import random
from math import isfinite, isnan, nan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.datagrams.visual_sample import LinkTimes
from stillarm.common.link import clock_offset
from stillarm.common.link.clock_offset import ClockOffset


def exchange(
    clock: ClockOffset,
    *,
    from_s: float,
    to_s: float,
    offset_s: float,
    skew: float,
    there_s: float = 100e-6,
    back_s: float = 100e-6,
    jitter_there_s: float = 0.0,
    jitter_back_s: float = 0.0,
    seed: int = 0,
    rate_hz: float = 65.0,
) -> None:
    """A supervisor that looks for timestamps at each frame and a controller that looks every millisecond."""
    draw = random.Random(seed)
    at = from_s
    while at < to_s:
        at += draw.uniform(0.8, 1.2) / rate_hz
        sent = int(at * 1000.0) / 1000.0  # the latest timestamp that can have arrived by then
        arrives = sent + there_s + draw.expovariate(1.0) * jitter_there_s
        read = max(at, arrives)
        answered = read + 0.003
        back = answered + back_s + draw.expovariate(1.0) * jitter_back_s
        received = (int(back * 1000.0) + 1) / 1000.0

        def there(t: float) -> float:
            return t + offset_s + skew * t

        clock.add(LinkTimes(sent, there(read), there(answered)), received)


@pytest.mark.parametrize("offset_s", [0.0, 12345.678, -3.2e5])
@pytest.mark.parametrize("skew", [0.0, 80e-6, -200e-6])
def test_offset_and_skew_are_found(offset_s: float, skew: float) -> None:
    """Within 50 us and 3 ppm in half a minute of frames."""
    clock = ClockOffset()
    exchange(clock, from_s=10.0, to_s=45.0, offset_s=offset_s, skew=skew, jitter_there_s=50e-6)
    found = clock.estimate
    assert abs(found.offset_s - (offset_s + skew * found.time_s)) < 50e-6
    assert abs(found.skew - skew) < 3e-6
    assert 200e-6 <= found.round_trip_s + 20e-6 < 400e-6
    assert clock.steps == 0


@settings(max_examples=25, deadline=None)
@given(st.floats(50e-6, 0.02), st.floats(50e-6, 0.02), st.floats(0.0, 0.005), st.integers(0, 99))
def test_the_error_is_never_more_than_half_the_round_trip(
    there_s: float, back_s: float, jitter_s: float, seed: int
) -> None:
    """Asymmetric delays look like an offset; only the bound is promised."""
    clock = ClockOffset()
    exchange(
        clock, from_s=0.0, to_s=20.0, offset_s=5.0, skew=50e-6, there_s=there_s, back_s=back_s,
        jitter_there_s=jitter_s, jitter_back_s=jitter_s / 3.0, seed=seed,
    )  # fmt: skip
    found = clock.estimate
    error = found.offset_s - (5.0 + 50e-6 * found.time_s)
    assert abs(error) <= 0.5 * found.round_trip_s + 3.0 * found.offset_std_s
    assert found.round_trip_s >= there_s + back_s - 100e-6


def test_a_network_that_queues_one_way_for_seconds_does_not_pull_the_clock() -> None:
    """Ten milliseconds one way for six of thirty seconds."""
    clock = ClockOffset()
    for start in range(0, 30, 5):
        busy = 0.01 if start in {10, 20} else 0.0
        exchange(
            clock, from_s=start, to_s=start + 2.0, offset_s=1.0, skew=0.0, back_s=1e-4 + busy, seed=start
        )
        exchange(clock, from_s=start + 2.0, to_s=start + 5.0, offset_s=1.0, skew=0.0, seed=start + 1)
    assert abs(clock.estimate.offset_s - 1.0) < 50e-6
    assert abs(clock.estimate.skew) < 5e-6


@pytest.mark.parametrize("step_s", [0.5, -0.5, 0.02])
def test_a_clock_that_was_set_is_followed_within_two_seconds(step_s: float) -> None:
    """And counted."""
    clock = ClockOffset()
    exchange(clock, from_s=0.0, to_s=20.0, offset_s=1.0, skew=20e-6)
    exchange(clock, from_s=20.0, to_s=23.5, offset_s=1.0 + step_s, skew=20e-6)
    assert abs(clock.estimate.offset_s - (1.0 + step_s + 20e-6 * clock.estimate.time_s)) < 2e-4
    assert clock.steps >= 1


def test_nothing_is_said_before_a_second_and_no_skew_before_three() -> None:
    clock = ClockOffset()
    exchange(clock, from_s=0.1, to_s=0.9, offset_s=1.0, skew=0.0)
    assert isnan(clock.estimate.offset_s)
    exchange(clock, from_s=0.9, to_s=1.5, offset_s=1.0, skew=0.0)
    assert isfinite(clock.estimate.offset_s) and isnan(clock.estimate.skew)


@given(st.lists(st.tuples(*[st.floats(width=64)] * 4), max_size=20))
def test_any_times_are_survived(times: list[tuple[float, float, float, float]]) -> None:
    clock = ClockOffset()
    for sent, received, answered, back in times:
        clock.add(LinkTimes(sent, received, answered), back)
    clock.add(LinkTimes(), nan)


def test_no_exchange_pays_for_more_than_one_pass_over_the_seconds(monkeypatch: pytest.MonkeyPatch) -> None:
    """The fit lies inside a 1 ms cycle; counted are passes, as a time would judge the machine."""
    passes = 0
    for name in ("_line", "_residuals"):
        real = getattr(clock_offset, name)

        def counted(*arguments: object, real: object = real, name: str = name) -> object:
            nonlocal passes
            passes += (
                30 if name == "_line" else 1
            )  # a line passes over all seconds, a residual is one of them
            return real(*arguments)  # type: ignore[operator]

        monkeypatch.setattr(clock_offset, name, counted)
    clock, worst = ClockOffset(), 0
    draw = random.Random(1)
    for k in range(65 * 60):
        at, before = k / 65.0, passes
        clock.add(
            LinkTimes(at, at + 1.0 + draw.expovariate(1e4), at + 1.003), at + 0.003 + draw.expovariate(1e4)
        )
        worst = max(worst, passes - before)
    assert isfinite(clock.estimate.skew)
    assert 0 < worst <= 60  # a pass over 30 seconds, and the choice of those that are kept


def test_a_slow_camera_gets_its_clock_all_the_same() -> None:
    """Two frames a second: the stages of a fit then take longer than the second after which they begin."""
    clock = ClockOffset()
    exchange(clock, from_s=0.0, to_s=60.0, offset_s=3.0, skew=50e-6, rate_hz=2.0)
    found = clock.estimate
    assert (
        abs(found.offset_s - (3.0 + 50e-6 * found.time_s)) < 1.1e-3
    )  # two looks a second seldom meet the shortest way
    assert isfinite(found.skew) and found.time_s > 45.0
