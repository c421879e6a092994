"""Faults in closed loop, in virtual time: the reaction, its time, the state, and the way back.

The arm and its image are tests.reference.arm_world's, integrated apart from the controller.
"""

from collections.abc import Callable
from math import inf, nan

import msgspec
import numpy as np
import pytest

from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.configuration import Safety
from stillarm.common.files.model import Commissioned, Model
from stillarm.controller.estimation.estimate import DelayEstimate, Estimate, Observation, Status
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.loop.step import Controller
from stillarm.controller.safety.table import GROUND_OF, Event, Operator, State
from tests.fixtures.safety_loop import (
    MODEL,
    SETTINGS,
    A,
    from_2_s,
    run,
    silent,
    states,
    wrong_participation,
)


def test_armed_by_itself_and_damping_without_any_fault() -> None:
    """Armed from the first cycle, degraded only until the first images; then the states follow the damping."""
    trace = run(lambda read: None)
    assert states(trace, 0.4, 3.0) == {(State.DAMPING, None)}
    assert trace.outputs[1].state is State.DEGRADED


def test_a_drive_lost_for_more_than_a_second_needs_the_preflight_again() -> None:
    """And the operator, unless arming at the start is allowed."""
    settings = Settings(method="correlation", arm_at_start=False)

    def arm_then_lose(read: CycleInput) -> None:
        if read.cycle == 100:
            read.operator = Operator.ARM
        from_2_s(silent, 3.2)(read)

    trace = run(arm_then_lose, 4.0, settings)
    assert states(trace, 0.01, 0.1) == {(State.IDLE, None)}
    assert states(trace, 3.01, 3.2) == {(State.PREFLIGHT, Event.DRIVE_LOST)}
    assert states(trace, 3.21, 4.0) == {(State.IDLE, None)}
    assert np.all(trace.arrays()["command"][3000:] == 0.0)


def test_the_emergency_stop_zeroes_at_once_and_stays() -> None:
    """Held for 50 ms only; clear and arm bring motion back."""

    def stop(read: CycleInput) -> None:
        if 2000 <= read.cycle < 2050:
            read.operator = Operator.EMERGENCY_STOP
        read.operator |= {2500: Operator.CLEAR, 2600: Operator.ARM}.get(read.cycle, 0)

    trace = run(stop)
    command = trace.arrays()["command"]
    assert np.all(command[2040:2600] == 0.0)
    assert states(trace, 2.0, 2.5) == {(State.FAULT, Event.EMERGENCY_STOP)}
    assert states(trace, 2.501, 2.6) == {(State.IDLE, None)}
    assert np.max(np.abs(command[2800:])) > 0.01


@pytest.mark.slow
@pytest.mark.parametrize("shaping", ["none", "zv", "zvd"])
def test_disarming_fades_within_a_tenth_of_a_second_the_shaped_tail_included(shaping: str) -> None:
    """Steadily: no step larger than a fade of 0.1 s makes; and a later arming starts from where the joint is."""
    settings = Settings(arm_at_start=True, method="correlation", reference_shaping=shaping)  # type: ignore[arg-type]

    def disarm(read: CycleInput) -> None:
        read.operator = {2000: Operator.DISARM, 2500: Operator.ARM}.get(read.cycle, 0)

    until_s = 2.2 if shaping == "none" else 1.99
    trace = run(disarm, 4.0, settings, strikes={}, reference=lambda t: 0.3 if t < until_s else 0.0)
    arrays = trace.arrays()
    command = arrays["command"]
    assert command[2000] > 0.1
    assert np.all(command[2105:2500] == 0.0)
    assert np.max(np.abs(np.diff(command[2000:2105]))) < 0.3 / 100 * 2.0
    assert np.max(np.abs(arrays["joint"][2600:] - arrays["joint"][2500])) < 0.02
    assert states(trace, 2.1, 2.5) == {(State.IDLE, Event.DISARM)}


def test_arming_into_a_reference_that_is_already_there_fades_it_in() -> None:
    """Over 0.2 s, without a step."""

    def arm(read: CycleInput) -> None:
        read.operator = Operator.ARM if read.cycle == 1000 else 0

    settings = Settings(method="correlation", arm_at_start=False)
    command = run(arm, 1.5, settings, strikes={}).arrays()["command"]
    assert np.all(command[:1000] == 0.0)
    assert np.max(np.abs(np.diff(command[1000:1150]))) < 0.05 / 200 * 3.0
    assert command[1400] == pytest.approx(0.05, abs=0.01)


class Broken:
    """A method whose numbers turn bad at 2 s."""

    def __init__(self, value: float, until_s: float) -> None:
        self.value, self.until_s = value, until_s

    def update(self, seen: Observation) -> Estimate:
        bad = 2.0 <= seen.time_s < self.until_s
        delay = DelayEstimate(0.07, 0.001, Status.ESTIMATED)
        return Estimate(delay, self.value if bad else 0.004, 0.0, 1e-4, Status.ESTIMATED)


@pytest.mark.slow
@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_numbers_that_are_not_finite_damp_nothing_and_soon_are_a_fault(value: float) -> None:
    """The damping is zero in the same cycle, the whole command after 0.05 s; a moment of them passes."""
    for until_s, fault in ((2.03, False), (inf, True)):
        controller = Controller(MODEL, SETTINGS)
        controller.method = Broken(value, until_s)
        trace = run(lambda read: None, controller=controller, strikes={})
        assert trace.outputs[1990].damping_rad_s > 0.002
        assert all(
            output.damping_rad_s == 0.0 for output in trace.outputs[2000 : round(1000 * min(until_s, 3.0))]
        )
        command = trace.arrays()["command"]
        assert np.all(np.isfinite(command))
        assert np.all(command[2095:] == 0.0) == fault
        assert ((State.FAULT, Event.NON_FINITE) in states(trace, 2.0, 3.0)) == fault


def wrong_camera(model: Model) -> Model:
    return msgspec.structs.replace(model, camera=msgspec.structs.replace(model.camera, scale_px_per_m=-800.0))


def late(model: Model) -> Model:
    return msgspec.structs.replace(model, timing=msgspec.structs.replace(model.timing, capture_delay_s=0.25))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("wrong", "method", "largest"),
    [
        (wrong_camera, "correlation", 3.0),
        (wrong_participation, "correlation", 6.0),
        (late, "kalman_constant_delay", 3.0),
    ],
)
def test_damping_with_the_wrong_phase_is_found_out(
    wrong: Callable[[Model], Model], method: str, largest: float
) -> None:
    """Before the vibration exceeds `largest` times the amplitude of the impact; then nothing moves any more."""
    trace = run(
        lambda read: None,
        6.0,
        Settings(arm_at_start=True, method=method),
        wrong(MODEL),
        {0.5: A},
        reference=lambda t: 0.0,
    )
    arrays = trace.arrays()
    faults = [k for k, output in enumerate(trace.outputs) if output.state is State.FAULT]
    assert faults and trace.outputs[faults[0]].reason is Event.GROWING
    assert np.max(np.abs(arrays["truth"])) < largest * A
    stopped = faults[0] + round(1000 * GROUND_OF[Event.GROWING].zero_within_s) + 20
    assert np.all(arrays["command"][stopped:] == 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("method", ["timestamps", "correlation"])
def test_impacts_are_no_growth(seed: int, method: str) -> None:
    """Twenty of them, at random times and strengths, up to three times the usual one."""
    random = np.random.default_rng(seed)
    impacts = {
        float(t): float(a)
        for t, a in zip(random.uniform(0.5, 8.0, 20), random.normal(0.0, A, 20), strict=True)
    }
    trace = run(
        lambda read: None,
        8.5,
        Settings(arm_at_start=True, method=method),
        strikes=impacts,
        reference=lambda t: 0.0,
    )
    assert states(trace, 0.5, 8.5) == {(State.DAMPING, None)}


def test_checks_before_arming() -> None:
    """A joint outside its limits arms nothing; images and accelerometer count where the configuration asks."""
    controller = Controller(MODEL, SETTINGS)
    assert controller.step(CycleInput(0, 0.0, 1.5, 0.0, 0.0)).state is State.PREFLIGHT
    assert controller.step(CycleInput(1, 0.0, 0.5, 0.0, 0.0)).state is State.ARMED
    needs = Settings(
        arm_at_start=True,
        method="correlation",
        safety=Safety(checks_before_arming=("vision", "accelerometer")),
    )
    trace = run(from_2_s(lambda read: None), 1.0, needs)
    assert trace.outputs[50].state is State.PREFLIGHT and trace.outputs[200].state is not State.PREFLIGHT
    blind = Controller(MODEL, needs)
    assert {blind.step(CycleInput(k, 0.0, 0.0, 0.0, 0.0)).state for k in range(300)} == {State.PREFLIGHT}


@pytest.mark.slow
def test_a_model_that_no_rig_has_given_moves_and_is_not_damped() -> None:
    """On hardware; with the mark it is, and in a simulation the mark does not matter."""
    marked = msgspec.structs.replace(MODEL, commissioned=Commissioned("2026-01-31", "recording.mcap"))
    controller = Controller(MODEL, SETTINGS, identified_only=True)
    refused = run(lambda read: None, controller=controller)
    assert states(refused, 0.1, 3.0) == {(State.DEGRADED, Event.UNCOMMISSIONED)}
    assert all(output.damping_rad_s == 0.0 for output in refused.outputs)
    assert max(output.command_rad_s for output in refused.outputs) == pytest.approx(0.05)
    for model, only in ((marked, True), (MODEL, False)):
        damped = run(lambda read: None, controller=Controller(model, SETTINGS, identified_only=only))
        assert (State.DAMPING, None) in states(damped, 1.0, 3.0)
        assert not any(output.reason is Event.UNCOMMISSIONED for output in damped.outputs)
