"""When the supervisor is killed."""

from stillarm.benchmarks.live.kills.kill_plan import BEFORE_KILL_S, plan


def test_every_gap_comes_once_each_after_a_strike_of_its_own() -> None:
    gaps = [0.3, 1.0, 3.0, 10.0]
    kills, scenario = plan(gaps, 3)
    assert sorted(kill.gap_s for kill in kills) == gaps
    assert [kill.gap_s for kill in kills] != [kill.gap_s for kill in plan(gaps, 4)[0]]
    assert len(scenario.strikes) == 4 and not scenario.moves and not scenario.damping
    for strike, kill in zip(scenario.strikes, kills, strict=True):
        assert BEFORE_KILL_S <= kill.at_s - strike.time_s <= BEFORE_KILL_S + 0.4
    for kill, strike in zip(kills, scenario.strikes[1:], strict=False):
        assert kill.at_s + kill.gap_s + 3.5 < kill.until_s < strike.time_s
    assert kills[-1].until_s < scenario.duration_s
