"""Whose the missed deadlines are."""

from stillarm.benchmarks.live.misses import Gap, gaps, own_misses


def test_a_miss_is_the_loops_own_where_the_bare_timer_missed_none() -> None:
    """A stall that hits both does not hit them at the same instant."""
    loop = gaps([0, 1, 5, 6, 50, 51, 53])
    assert loop == [Gap(1, 3), Gap(6, 43), Gap(51, 1)]
    assert own_misses(loop, []) == 47
    assert own_misses(loop, [Gap(2, 3), Gap(30, 2)]) == 1
    assert own_misses(loop, [Gap(0, 60)]) == 0
    assert own_misses([], [Gap(0, 60)]) == 0
