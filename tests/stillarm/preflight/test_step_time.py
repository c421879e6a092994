"""Which rate a machine keeps."""

import time

import pytest

from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.model import Arm, Model
from stillarm.controller.estimation.estimate import DelayEstimate, Estimate, Observation, Status
from stillarm.controller.estimation.methods import METHODS
from stillarm.preflight import step_time
from stillarm.preflight.step_time import REST, StepFacts, check_step, judge_step, measure_step
from stillarm.preflight.verdict import Level

FAST, SLOW = StepFacts("correlation", 20e-6, 100e-6), StepFacts("fused", 300e-6, 1500e-6)
MODEL = Model(arm=Arm(length_m=2.0))


class Slow:
    """A method that takes 3 ms."""

    def __init__(self, *_: object) -> None:
        pass

    def update(self, observation: Observation) -> Estimate:
        until = time.perf_counter() + 0.003
        while time.perf_counter() < until:
            pass
        return Estimate(DelayEstimate(0.07, 0.01, Status.UNESTIMATED))


def test_the_rate_follows_from_the_busiest_cycle() -> None:
    """1.5 ms and 1.3 * 0.3 ms: 529 Hz."""
    assert SLOW.busiest_s == pytest.approx(1.5e-3 + REST * 0.3e-3)
    assert SLOW.fastest_hz == 500.0


def test_a_method_that_is_kept_is_told_with_the_others() -> None:
    verdict = judge_step([FAST, SLOW], 0.001)
    assert verdict.level is Level.OK
    assert "1000 Hz is kept, and up to 7000 Hz (fused 500)" in verdict.text


def test_a_method_that_is_too_slow_names_both_remedies() -> None:
    verdict = judge_step([SLOW, FAST], 0.001)
    assert verdict.level is Level.WARN
    assert "timing.cycle_s = 0.002 in the model, or controller.method = correlation" in verdict.text
    assert judge_step([SLOW, FAST], 0.002).level is Level.OK


@pytest.mark.slow
def test_a_slow_method_is_found_slow(monkeypatch: pytest.MonkeyPatch) -> None:
    """3 ms a step, whatever the machine; a second method takes less than a tenth of it. What leads up to the measured
    steps is shorter than in use: neither method begins anew after an impact."""
    monkeypatch.setitem(METHODS, "slow", Slow)
    monkeypatch.setattr(step_time, "_AT_ONCE", 20)
    slow = measure_step(MODEL, Settings(), "model", "slow")
    fast = measure_step(MODEL, Settings(), "model", "timestamps")
    assert 0.003 <= slow.median_s <= slow.greatest_s
    assert fast.median_s < 0.1 * slow.median_s


def test_a_model_without_length_is_one_failed_check() -> None:
    verdict = check_step(Model(), Settings(), "model.toml")
    assert verdict.level is Level.FAIL and "length_m" in verdict.text
