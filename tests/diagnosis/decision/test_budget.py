"""A diagnosis within a budget, in virtual time: stages are abandoned, not the verdict."""

import pytest

from stillarm.diagnosis.data.measured import first_part
from stillarm.diagnosis.decision.budget import (
    MIN_S,
    MIN_STAGES_SHARE,
    RUNS,
    VERDICT_S,
    VERDICT_SHARE,
    Budget,
    affordable,
)
from stillarm.diagnosis.diagnose import diagnose_measured
from stillarm.diagnosis.physics.computing import OutOfTime, check_time, side_by_side
from stillarm.diagnosis.physics.world import World
from tests.fixtures.synthetic import MODEL, measured


class Clock:
    """A clock that moves on by a step each time it is read."""

    def __init__(self, step_s: float = 0.0) -> None:
        self.now_s, self.step_s = 100.0, step_s

    def __call__(self) -> float:
        self.now_s += self.step_s
        return self.now_s


def test_a_limit_ends_with_its_share_and_outside_there_is_none() -> None:
    clock = Clock()
    budget = Budget(20.0, clock.now_s, clock)
    with budget.limit(0.5):
        clock.now_s += 0.49 * budget.stages_s
        check_time()
        clock.now_s += 0.02 * budget.stages_s
        with pytest.raises(OutOfTime):
            check_time()
    check_time()
    with Budget(None, 0.0, clock).limit():
        check_time()


def test_the_verdict_keeps_its_time_and_the_stages_of_a_small_budget_theirs() -> None:
    assert Budget(10.0, 0.0).stages_s == pytest.approx(10.0 - VERDICT_S)
    assert Budget(60.0, 0.0).stages_s == pytest.approx(60.0 * (1.0 - VERDICT_SHARE))
    assert Budget(2.0, 0.0).stages_s == pytest.approx(2.0 * MIN_STAGES_SHARE)


def test_the_limit_holds_for_work_on_the_other_core_too() -> None:
    clock = Clock()
    with Budget(10.0, clock.now_s - 60.0, clock).limit(), pytest.raises(OutOfTime):
        side_by_side(lambda item: check_time(), [1, 2, 3])
    assert side_by_side(lambda item: check_time(), [1, 2]) == [None, None]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seconds", "left_out"),
    [
        (0.001, {"impacts", "baseline", "some forms of causes", "structure without a name"}),
        (None, set()),
    ],
)
def test_what_the_time_does_not_suffice_for_is_told(seconds: float | None, left_out: set[str]) -> None:
    """Every reading of the clock takes a millisecond, so that the count of simulations decides, not the machine."""
    clock = Clock(1e-3)
    result = diagnose_measured(measured(6.0, 3), MODEL, budget=Budget(seconds, clock.now_s, clock))
    looked = result.table["looked_at"]
    assert left_out == set(looked["left_out"])
    assert looked["budget_s"] == seconds and looked["seconds"] > 0.0
    assert result.table["verdict"] in ("none", "unexplained")
    if seconds is None:
        assert result.table["verdict"] == "none"


def test_a_long_recording_is_cut_to_what_can_be_afforded() -> None:
    world = World(measured(30.0, 3), MODEL)
    clock = Clock(0.05)  # one simulation takes so long
    needed_s = RUNS * 0.05
    budget = Budget(0.5 * needed_s / (1.0 - VERDICT_SHARE), clock.now_s, clock)
    assert affordable(world, budget) == pytest.approx(15.0, rel=0.1)
    assert affordable(world, Budget(None, clock.now_s, clock)) == 30.0
    assert affordable(world, Budget(1.0, clock.now_s, clock)) == MIN_S


def test_the_first_part_is_a_recording_of_its_own() -> None:
    whole = measured(12.0, 3)
    part = first_part(whole, 5.0)
    assert part.duration_s == pytest.approx(5.0)
    assert (part.acceleration == whole.acceleration[: part.cycles]).all()
    assert 0 < len(part.frames) < len(whole.frames) and part.frames.received_s.max() < 5.0
