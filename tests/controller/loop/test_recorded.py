"""From recorded rows to what the step read, with all that measured data may do."""

from math import isnan, nan

import msgspec

from stillarm.common.files.configuration import default_configuration_path, load_configuration
from stillarm.common.files.model import Arm, Model
from stillarm.common.recording.topics import EstimateSample, FastSample, FrameSample
from stillarm.controller.command.damping import DampingStatus
from stillarm.controller.estimation.estimate import DelayEstimate, Estimate, Status, Trust
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.loop.recorded import (
    estimate_sample,
    fast_sample,
    frame_sample,
    recorded_cycles,
    visual_sample,
)
from stillarm.controller.loop.step import Controller, CycleOutput
from stillarm.controller.replay.replay import RecordedRun, compare_with_live


def frame(cycle: int, number: int, received_s: float | None = None) -> FrameSample:
    received = cycle * 0.001 if received_s is None else received_s
    return FrameSample(received, cycle, number, received, nan, -1, 0, displacement_px=float(number))


def test_frames_are_read_once_in_order_each_in_its_own_cycle() -> None:
    """Rows 3 and 4 are missing, as at a lower rate; the frames are not in order; the last one comes after all rows."""
    fast = [FastSample(cycle * 0.001, cycle) for cycle in (0, 1, 2, 5, 6)]
    frames = [frame(6, 3), frame(1, 0), frame(3, 1), frame(4, 2), frame(9, 4)]
    got = [(c.read.cycle, [s.frame for s in c.read.samples]) for c in recorded_cycles(fast, frames)]
    assert got == [(0, []), (1, [0]), (2, []), (3, [1]), (4, [2]), (5, []), (6, [3])]
    alone = [c for c in recorded_cycles(fast, frames) if c.row is None]
    assert [c.read.cycle for c in alone] == [3, 4]
    assert all(isnan(c.read.acceleration_m_s2) for c in alone)


def test_times_stay_as_they_were_recorded() -> None:
    """Off the cycle's grid, for the tables that outside scripts join."""
    (cycle,) = recorded_cycles([FastSample(0.00123, 1)], [frame(1, 0, 0.00111)])
    assert cycle.row is not None and cycle.row.time_s == 0.00123
    assert cycle.frames[0].received_s == 0.00111


def test_two_rows_in_a_cycle_and_a_clock_that_steps_back() -> None:
    """The first row counts; the step never sees its cycles go back."""
    cycles = [0, 1, 1, 2, 1, 0, 2, 3]
    fast = [FastSample(0.0, cycle, acceleration_m_s2=float(k)) for k, cycle in enumerate(cycles)]
    got = [(c.read.cycle, c.read.acceleration_m_s2) for c in recorded_cycles(fast, [])]
    assert got == [(0, 0.0), (1, 1.0), (2, 3.0), (3, 7.0)]


def test_a_missing_reference_is_none_and_a_missing_command_stays_missing() -> None:
    """A recording of a ring-down may have no commands."""
    (cycle,) = recorded_cycles([FastSample(0.0, 0)], [])
    assert cycle.read.reference_rad_s == 0.0
    assert isnan(cycle.command_rad_s)


def test_a_visual_sample_survives_recording() -> None:
    """Every field, both ways."""
    sample = visual_sample(frame(5, 7))
    assert repr(visual_sample(frame_sample(sample, 5, 0.001))) == repr(sample)


def test_the_row_holds_what_the_step_read() -> None:
    """Under the names of fast.csv."""
    read = CycleInput(3, 1.5, 0.1, 0.2, 0.0, 0.05, True, [])
    answered = CycleOutput(
        0.07, 0.02, DampingStatus.ACTIVE, Estimate(DelayEstimate(0.07, 0.001, Status.ESTIMATED)), 0.001
    )
    row = fast_sample(read, answered, 0.001)
    assert (row.time_s, row.cycle, row.acceleration_m_s2) == (0.003, 3, 1.5)
    assert (row.joint_velocity_command_rad_s, row.joint_velocity_reference_rad_s) == (0.07, 0.05)
    assert (row.joint_position_rad, row.damping_allowed) == (0.1, True)


def test_a_cycles_trust_is_recorded() -> None:
    """For a method without its own trust it follows from the status of the delay."""
    unknown = DelayEstimate(0.07, 0.001, Status.UNESTIMATED)
    for trust, recorded in ((Trust.DOUBTFUL, "doubtful"), (None, "starting")):
        answered = CycleOutput(0.0, 0.0, DampingStatus.OFF, Estimate(unknown, trust=trust), 0.0)
        row = msgspec.json.decode(msgspec.json.encode(estimate_sample(3, answered, 0.001)))
        assert row["trust"] == recorded


def recorded_run() -> RecordedRun:
    """Fifty cycles as a controller recorded them."""
    configuration, model = load_configuration(default_configuration_path()), Model(arm=Arm(length_m=2.0))
    controller = Controller(model, configuration.controller, "model")
    fast: list[FastSample] = []
    estimates: list[EstimateSample] = []
    for cycle in range(50):
        read = CycleInput(cycle, 0.1, 0.0, 0.0, 0.0, 0.0, False, [])
        answered = controller.step(read)
        fast.append(fast_sample(read, answered, 0.001))
        estimates.append(estimate_sample(cycle, answered, 0.001))
    return RecordedRun("rec", configuration, model, fast, [], estimates)


def test_a_recording_from_before_there_was_trust_replays_to_the_same_numbers() -> None:
    """The field is read as empty there, and is not compared; another trust than was recorded is a difference."""
    run = recorded_run()
    assert compare_with_live(run).identical
    assert {estimate.trust for estimate in run.estimates} == {"starting"}
    row = msgspec.to_builtins(run.estimates[7])
    del row["trust"]
    run.estimates[7] = msgspec.convert(row, EstimateSample, strict=False)
    assert run.estimates[7].trust == ""
    comparison = compare_with_live(run)
    assert comparison.identical, comparison.first_difference
    run.estimates[7] = msgspec.structs.replace(run.estimates[7], trust="doubtful")
    comparison = compare_with_live(run)
    assert comparison.different == 1
    assert comparison.first_difference is not None and "trust" in comparison.first_difference
