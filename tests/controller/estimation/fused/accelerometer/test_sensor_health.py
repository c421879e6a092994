"""The accelerometer's faults, one by one: each is named, counts less, and is over when it is over."""

from collections.abc import Callable
from math import nan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.files.configuration import Controller as Settings
from stillarm.controller.estimation.estimate import Observation, Status
from stillarm.controller.estimation.fused.accelerometer.clipping import Clipping
from stillarm.controller.estimation.fused.accelerometer.sensor_health import AccelerometerHealth
from stillarm.controller.estimation.fused.method import FusedMethod
from stillarm.controller.joint.joint_motion import JointMotion
from tests.reference.ringing_world import model_for, ring

AMPLITUDE = 0.006
UNIT = AMPLITUDE * (2.0 * np.pi * 2.6) ** 2  # m/s^2
DIES_AT, BACK_AT, END = 4000, 9000, 14000  # cycles


def healthy() -> AccelerometerHealth:
    return AccelerometerHealth(0.001, 19.6, 1e-6, 1.0 / 267.0)


def test_samples_missing_held_or_out_of_range_are_not_used() -> None:
    """And the reason is told once it lasts."""
    health = healthy()
    assert health.usable(1.0, 0.0)
    assert not health.usable(1.0, 0.0)
    assert not health.usable(nan, 0.0)
    assert not health.usable(19.5, 0.0)
    assert health.usable(1.1, 0.0)
    assert health.reason == ""
    for _ in range(40):
        health.usable(1.1, 0.0)
    assert health.reason == "accelerometer stuck"
    for _ in range(40):
        health.usable(nan, 0.0)
    assert health.reason == "accelerometer silent"


def test_a_gain_far_from_one_mutes_and_a_gain_of_one_gives_the_sensor_back() -> None:
    """By its blocks against the vibration that images show; an offset changes nothing in that."""
    health = healthy()
    wave = [float(np.sin(0.26 * k)) for k in range(400)]
    for value in wave:
        health.compare(value + 0.01, value, 0.005)
    assert not health.mute
    for value in wave:
        health.compare(0.1 * value, value, 0.005)
    assert health.mute
    for value in wave:
        health.compare(value, value, 0.005)
    assert not health.mute


def test_an_offset_that_no_chance_explains_loosens_the_bias() -> None:
    """By its own square, and less and less in the blocks after it."""
    health = healthy()
    loosened = [health.compare(0.5, 0.0, 0.01) for _ in range(12)]
    assert max(loosened) == pytest.approx(0.25)
    assert 0.0 < loosened[-1] < 0.05


def test_more_alarms_than_any_arm_is_struck_are_not_believed() -> None:
    """One is; ten in a second are not; nor any while the sensor contradicts the images."""
    health = healthy()
    assert health.alarm(1.0, 1.1)
    believed = [health.alarm(1.0 + 0.1 * k, 1.1) for k in range(1, 11)]
    assert not believed[-1]
    assert health.alarm(5.0, 1.1)
    for k in range(40):
        health.compare(float(np.sin(0.26 * k)) + 1.0, -float(np.sin(0.26 * k)), 0.01)
    assert not health.alarm(9.0, 1e3)


def test_an_impact_must_stand_out_from_what_the_sensor_contradicts_anyway() -> None:
    """Differences from the images twice as large, squared, as they should be: an impact by less than twice is none."""
    health = healthy()
    for k in range(200):
        health.compare(float(np.sqrt(0.02)) * (-1.0) ** k, 0.0, 0.01)
    assert not health.alarm(1.0, 1.5)
    assert health.alarm(3.0, 2.5)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    st.integers(0, 2**32 - 1), st.floats(0.1, 1.3), st.sampled_from([0.0, 0.0096]), st.sampled_from([-1, 1])
)
def test_a_limit_is_found_where_a_signal_is_cut_and_nowhere_else(
    seed: int, level: float, step: float, sign: int
) -> None:
    """A noisy vibration, in counts or not, cut on one side where it often gets: that side's limit within
    four seconds, and no other.
    """
    random = np.random.default_rng(seed)
    time_s = np.arange(4000) * 0.001
    signal = np.sin(16.3 * time_s + random.uniform(0.0, 6.0)) + 0.3 * random.standard_normal(4000)
    if step:
        signal = np.round(signal / step) * step
    whole, cut = Clipping(19.2), Clipping(19.2)
    for value in signal.tolist():
        whole.see(value)
        cut.see(sign * min(value, level))
    assert not whole.found
    assert cut.found
    high, low = (level, -19.2) if sign > 0 else (19.2, -level)
    assert (cut.high, cut.low) == pytest.approx((high, low))
    assert cut.near(sign * level, 0.1)
    assert not cut.near(0.0, 0.09)
    cut.see(sign * 2.0)
    assert not cut.found  # a sample beyond it: it was no limit, or is none any more


def faulty(fault: Callable[[int, float, np.random.Generator], float], mode: str = "freerun") -> "Said":
    """A trial under steady excitation with a fault from DIES_AT to BACK_AT."""
    model = model_for(AMPLITUDE, 0.3, mode=mode)
    trial = ring(model, 91, END / 1000.0, triggered=mode == "triggered", delay="drift", excitation="steady")
    method = FusedMethod(model, Settings().fused, "model")
    joint = JointMotion(model, 2.0)
    random = np.random.default_rng(92)
    errors, reasons, statuses = np.full(END, nan), [], []
    for cycle in range(END):
        a = float(trial.acceleration[cycle])
        if DIES_AT <= cycle < BACK_AT:
            a = fault(cycle, a, random)
        joint.begin_cycle(cycle, nan)
        said = method.update(Observation(cycle, cycle * 0.001, a, trial.samples.get(cycle, []), joint))
        joint.send(0.0)
        errors[cycle] = (said.deflection_m - trial.deflection[cycle]) / trial.envelope[cycle]
        reasons.append(said.reason)
        statuses.append(said.delay.status)
    return Said(np.abs(errors), reasons, statuses)


class Said:
    """Errors as shares of the amplitude, reasons and statuses, by cycle."""

    def __init__(self, errors: np.ndarray, reasons: list[str], statuses: list[Status]) -> None:
        self.errors, self.reasons, self.statuses = errors, reasons, statuses


FAULTS: dict[str, tuple[Callable[[int, float, np.random.Generator], float], str]] = {
    "silent": (lambda k, a, r: nan, "accelerometer silent"),
    "zero": (lambda k, a, r: 0.0, "accelerometer stuck"),
    "rail": (lambda k, a, r: 19.6, "accelerometer stuck"),
    "noise alone": (lambda k, a, r: 0.3 * UNIT * r.standard_normal(), "accelerometer does not show the vibration"),
    "large noise alone": (
        lambda k, a, r: 3.0 * UNIT * r.standard_normal(),
        "accelerometer does not show the vibration",
    ),
    "weak": (lambda k, a, r: 0.5 * a, "accelerometer does not show the vibration"),
    "biased": (lambda k, a, r: a + 2.0, ""),
    "drifting": (lambda k, a, r: a + 0.3e-3 * (k - DIES_AT), "accelerometer's bias drifts"),
    "clipped": (lambda k, a, r: min(max(a, -0.5 * UNIT), 0.5 * UNIT), "accelerometer clipped"),
    "clipped on one side": (lambda k, a, r: min(a, 0.4 * UNIT), "accelerometer clipped"),
    "spiking": (
        lambda k, a, r: a + (20.0 * r.standard_normal() if r.uniform() < 0.03 else 0.0),
        "accelerometer spiking",
    ),
    "noisy": (lambda k, a, r: a + 1.5 * UNIT * r.standard_normal(), "accelerometer noisy"),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", FAULTS)
def test_each_fault_is_named_and_does_little(name: str) -> None:
    """A second after its onset: named in most cycles, and a mean error of 1.5 % under a free-running camera."""
    fault, reason = FAULTS[name]
    said = faulty(fault)
    during = slice(DIES_AT + 1000, BACK_AT)
    named = sum(one == reason for one in said.reasons[during]) / (BACK_AT - DIES_AT - 1000)
    assert named > 0.25
    assert np.mean(said.errors[during]) < 0.015
    after = slice(BACK_AT + 4000, END)
    assert sum(one == "" for one in said.reasons[after]) > 0.9 * (END - BACK_AT - 4000)
    assert np.mean(said.errors[after]) < 0.015
    assert Status.INVALID not in said.statuses


@pytest.mark.slow
def test_a_delay_that_can_no_longer_be_seen_is_held_and_says_why() -> None:
    """Triggered, drifting, without an accelerometer: uncertain in time, held, never unestimated again."""
    said = faulty(FAULTS["silent"][0], mode="triggered")
    assert Status.UNESTIMATED not in said.statuses[DIES_AT:]
    held = [
        r for r, s in zip(said.reasons, said.statuses, strict=True) if s is Status.HELD and r != "no images"
    ]
    assert all(held)
