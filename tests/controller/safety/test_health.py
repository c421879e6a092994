"""What is missing, and what goes on without it."""

from math import nan

import numpy as np
import pytest

from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.loop.step import Controller
from stillarm.controller.safety.table import GROUND_OF, Event, State
from tests.fixtures.safety_loop import MODEL, SETTINGS, from_2_s, run, silent, states


@pytest.mark.slow
def test_a_silent_drive_stops_everything_and_it_goes_on_by_itself() -> None:
    """Zero 0.1 s after the last report, motion 0.2 s after the first new one."""
    command = run(from_2_s(silent, 2.4)).arrays()["command"]
    trace = run(from_2_s(silent, 2.4))
    assert np.max(np.abs(command[1900:2000])) > 0.01
    ground = GROUND_OF[Event.DRIVE_SILENT]
    zero_from = 2000 + round(1000 * (ground.seen_within_s + ground.zero_within_s))
    assert np.all(command[zero_from:2400] == 0.0)
    assert states(trace, 2.1, 2.4) == {(State.DEGRADED, Event.DRIVE_SILENT)}
    assert np.max(np.abs(command[2500:])) > 0.01
    assert np.max(np.abs(np.diff(command))) <= MODEL.drive.max_acceleration_rad_s2 * 0.001 * 1.0001


def test_a_dead_accelerometer_is_told_and_the_damping_goes_on() -> None:
    """On the delay known last; and it is well again with the samples."""

    def dead(read: CycleInput) -> None:
        read.acceleration_m_s2 = nan

    trace = run(from_2_s(dead, 2.6), reference=lambda t: 0.0)
    assert states(trace, 2.06, 2.6) == {(State.DEGRADED, Event.ACCELEROMETER_DEAD)}
    command = trace.arrays()["command"]
    assert np.max(np.abs(command[2200:2600])) > 0.001
    assert states(trace, 2.85, 3.0) == {(State.DAMPING, None)}


def test_stale_vision_stops_the_damping_and_not_the_reference() -> None:
    """Within 0.2 s of the last image."""

    def blind(read: CycleInput) -> None:
        read.samples.clear()

    trace = run(from_2_s(blind, 2.5))
    parts = np.array([output.damping_rad_s for output in trace.outputs])
    assert np.max(np.abs(parts[1950:2000])) > 0.002
    assert np.all(parts[2150:2500] == 0.0)
    assert states(trace, 2.15, 2.5) == {(State.DEGRADED, Event.VISION_STALE)}
    assert np.allclose(trace.arrays()["command"][2200:2500], 0.05)
    assert states(trace, 2.75, 3.0) == {(State.DAMPING, None)}


def test_a_stall_zeroes_the_command_and_damping_waits_for_fresh_images() -> None:
    """The loop stood still for 0.3 s, in which the drive's dead-man timer has stopped the joint."""
    controller = Controller(MODEL, SETTINGS)
    outputs = []
    for cycle in (*range(1000), *range(1300, 2300)):
        outputs.append(controller.step(CycleInput(cycle, 0.0, 0.0, 0.0, 0.0, 0.05, True)))
    assert outputs[999].command_rad_s == 0.05
    stalled = outputs[1000:1500]
    assert all(output.command_rad_s == 0.0 and output.reason is Event.LOOP_STALLED for output in stalled)
    assert outputs[-1].command_rad_s == pytest.approx(0.05)
    steps = np.diff([output.command_rad_s for output in outputs[1000:]])
    assert np.max(np.abs(steps)) < 0.05 / 200 * 1.01


def test_missed_deadlines_stop_the_damping_and_not_the_reference() -> None:
    """Every second cycle is missed for three seconds."""
    controller, seen = Controller(MODEL, SETTINGS), []
    for cycle in (*range(1000), *range(1000, 4000, 2), *range(4000, 6000)):
        output = controller.step(CycleInput(cycle, 0.0, 0.0, 0.0, 0.0, 0.05, True))
        seen.append((cycle, output))
    late_ones = [output for cycle, output in seen if 2500 <= cycle < 4000]
    assert all(output.reason is Event.DEADLINES_MISSED for output in late_ones)
    assert all(output.command_rad_s == 0.05 for output in late_ones)
    assert seen[-1][1].reason is not Event.DEADLINES_MISSED
