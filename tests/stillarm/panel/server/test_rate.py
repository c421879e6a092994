"""The rate limit: its burst, its rate in the long run, and its memory."""

from hypothesis import given
from hypothesis import strategies as st

from stillarm.panel.server.rate import RateLimit


@given(st.lists(st.floats(0.0, 0.5), max_size=200))
def test_never_more_than_the_burst_and_the_rate(pauses_s: list[float]) -> None:
    limit, now_s, allowed = RateLimit(2.0, 5), 0.0, 0
    for pause_s in pauses_s:
        now_s += pause_s
        allowed += limit.allows("a", now_s)
    assert allowed <= 5 + 2.0 * now_s + 1e-6


def test_who_waits_is_served_and_addresses_are_apart() -> None:
    limit = RateLimit(1.0, 1)
    assert limit.allows("a", 0.0) and not limit.allows("a", 0.5)
    assert limit.allows("b", 0.5)
    assert limit.allows("a", 1.6)
    assert not limit.allows("a", 0.0)  # a clock that goes back gives nothing


def test_many_addresses_take_bounded_memory() -> None:
    limit = RateLimit(1.0, 1)
    for number in range(5000):
        limit.allows(str(number), 0.0)
    assert len(limit._buckets) <= 1024
