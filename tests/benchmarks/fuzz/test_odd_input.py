"""No value of the sensors or of the supervisor stalls the step or kills it: every method and field, in child processes.

The deadline and the limit for a step are in processor time, so that a busy machine fails no test.
"""

from functools import cache
from math import isnan, nan

import pytest
from hypothesis import HealthCheck, given, settings

from stillarm.benchmarks.fuzz.odd_child import run_in_child
from stillarm.benchmarks.fuzz.odd_input import check, complaints
from stillarm.benchmarks.fuzz.odd_plans import CYCLE_FLOATS, FIELDS, SAMPLE_FLOATS, plans
from stillarm.benchmarks.fuzz.odd_world import Odd, Plan, Verdict, World, warmed
from stillarm.controller.estimation.methods import METHODS
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.loop.step import CycleOutput

USUALLY = {"restarted": True, "damping_allowed": nan, "samples": 60, "pause": 100_000}
PROFILE = settings(
    max_examples=8, deadline=None, derandomize=True, database=None, suppress_health_check=list(HealthCheck)
)


@cache
def world_of(method: str) -> tuple[World, Verdict]:
    """A warm world, and what it comes to without odd values."""
    world = warmed(method)
    return world, run_in_child(world, Plan(()), None)


@pytest.mark.blind(each_run=2)
@pytest.mark.parametrize("method", METHODS)
def test_every_field_at_once(method: str) -> None:
    """NaN, then 1e300 (2^40 for a counter) in every field, in thirty cycles or samples each, while the damping acts."""
    world, usual = world_of(method)
    assert not usual.faults
    for far, whole in ((nan, -2), (1e300, 2**40)):
        floats = [Odd(7, name, far, 30) for name in (*CYCLE_FLOATS, *SAMPLE_FLOATS)]
        others = [
            Odd(20, name, USUALLY.get(name, whole), 1 if name == "pause" else 20)
            for name in FIELDS
            if name not in CYCLE_FLOATS and name not in SAMPLE_FLOATS
        ]
        check(world, Plan((*floats, *others), damping=True), usual)


@pytest.mark.blind(each_run=8)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("cycles", [10, 1000, 1001, 10**6])
def test_pauses(method: str, cycles: int) -> None:
    world, usual = world_of(method)
    check(world, Plan((Odd(7, "pause", cycles),), damping=True), usual)


@pytest.mark.blind(each_run=2)
@pytest.mark.parametrize("method", METHODS)
def test_drawn_plans(method: str) -> None:
    world, usual = world_of(method)

    @PROFILE
    @given(plan=plans())
    def run(plan: Plan) -> None:
        check(world, plan, usual)

    run()


class Harmful:
    """Replaces the step: does harm at the first NaN of the accelerometer."""

    def __init__(self, world: World, harm: str) -> None:
        self.true, self.harm = world.controller, harm
        self.method, self.refused = world.controller.method, world.controller.refused

    def step(self, read: CycleInput) -> CycleOutput:
        answered = self.true.step(read)
        if not isnan(read.acceleration_m_s2):
            return answered
        if self.harm == "raise":
            raise OverflowError("odd")
        if self.harm == "bounds":
            answered.command_rad_s = 7.0
        elif self.harm == "slow":
            sum(range(1_000_000))
        elif self.harm == "state":
            self.method.left = nan  # type: ignore[attr-defined]
        while self.harm == "hang":
            pass
        return answered


@pytest.mark.parametrize(
    ("harm", "told"),
    [
        ("raise", "raises"),
        ("bounds", "command"),
        ("slow", "a step of"),
        ("state", "NaN is left"),
        ("hang", "hangs"),
    ],
)
def test_harm_is_found(harm: str, told: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The tests above therefore cannot pass because the check is blind."""
    monkeypatch.setattr("stillarm.benchmarks.fuzz.odd_child.DEADLINE_S", 2)
    world, usual = warmed("timestamps"), world_of("timestamps")[1]
    monkeypatch.setattr(world, "controller", Harmful(world, harm))
    found = complaints(run_in_child(world, Plan((Odd(7, "acceleration_m_s2", nan),)), usual.error), usual)
    assert any(told in one for one in found), found
