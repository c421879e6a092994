"""What happens within a cycle that no model tells: which comes first, a command or a reading, and by how much."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision.explain import explain
from stillarm.diagnosis.physics.quantities import ARRIVAL, OF_ARRIVALS, OF_LAST_JUMP
from stillarm.diagnosis.physics.world import World
from tests.fixtures.synthetic import MODEL, empty, fitted, measured

Array = NDArray[np.float64]


@pytest.mark.parametrize("share", [0.0, 0.6, 1.0])
def test_an_accelerometer_may_show_any_share_of_a_jump_as_it_is_read(share: float) -> None:
    """With the model's dead time of whole cycles, commands arrive just when sensors are read."""
    assert MODEL.drive.dead_time_s == 2.0 * MODEL.timing.cycle_s
    found = fitted(measured(6.0, 5, {OF_ARRIVALS: share}))
    assert found.value(OF_ARRIVALS) == pytest.approx(share, abs=4.0 * found.std[OF_ARRIVALS])
    assert found.std[OF_ARRIVALS] < 0.2


@pytest.mark.slow
@pytest.mark.parametrize("late_s", [-5e-5, 1e-4])
def test_commands_that_come_a_tenth_of_a_cycle_off_are_nothing_wrong(late_s: float) -> None:
    """So does a simulation of another kind, with a step of a tenth of a cycle, differ from this one."""
    data = measured(12.0, 6, {ARRIVAL: late_s, OF_ARRIVALS: 0.5})
    baseline = fitted(data)
    assert baseline.value(ARRIVAL) == pytest.approx(late_s, abs=4.0 * baseline.std[ARRIVAL] + 1e-5)
    assert not explain(baseline, interleaved(12.0)).findings


def test_a_dead_time_is_told_to_what_is_unknown_within_a_cycle() -> None:
    """No better than that, and no worse."""
    found = fitted(measured(8.0, 7, {"drive.dead_time_s": 0.0137}), "drive.dead_time_s")
    assert found.value("drive.dead_time_s") == pytest.approx(0.0137, abs=2.0 * found.std["drive.dead_time_s"])
    assert 4e-5 < found.std["drive.dead_time_s"] < 2e-4


@pytest.mark.slow
def test_half_a_cycle_more_of_dead_time_is_found() -> None:
    """More than what is left open: as a direction, without its bounds, that would explain it all."""
    data = measured(12.0, 8, {"drive.dead_time_s": 0.0025})
    found = explain(
        fitted(data), interleaved(12.0), only=["drive_dead_time", "drive_lag", "accelerometer_lag"]
    )
    assert [one.cause for one in found.findings] == ["drive_dead_time"]
    assert found.final.value("drive.dead_time_s") == pytest.approx(0.0025, abs=1.5e-4)


@pytest.mark.parametrize("late_s", [0.0003, 0.0006, 0.0014])
def test_a_late_accelerometer_reads_before_a_command_or_after_it(late_s: float) -> None:
    """By a simulation ten times finer: interpolated between cycles, a jump of the joint's acceleration is half seen."""
    seconds, dead_s = 4.0, 0.0025
    step = np.repeat(np.random.default_rng(9).normal(0.0, 0.02, round(seconds / 0.005)), 5)
    values = {"drive.dead_time_s": dead_s, "accelerometer.delay_s": late_s, "modes.0.participation": 0.6}

    def read(cycle_s: float, share: float) -> Array:
        model = msgspec.structs.replace(MODEL, timing=msgspec.structs.replace(MODEL.timing, cycle_s=cycle_s))
        finer = round(0.001 / cycle_s)
        data = empty(seconds, model)
        commands = np.repeat(step, finer)[: data.cycles]
        world = World(replace(data, command=commands, reference=commands), model)
        vector = world.space.with_values(world.space.vector(), {**values, OF_LAST_JUMP: share})
        return world.predict(vector).channels["acceleration"][::finer][100:3900]

    true, interpolated = read(0.0001, 0.0), read(0.001, 0.0)
    direction = read(0.001, 1.0) - interpolated
    share = float(direction @ (true - interpolated) / (direction @ direction))
    left = true - interpolated - share * direction
    assert np.std(left) < 0.35 * np.std(true - interpolated)
    assert abs(share) < 1.0


@pytest.mark.slow
def test_a_late_accelerometer_is_told_from_a_drive_with_dead_time() -> None:
    """Whatever it reads of the last jump."""
    data = measured(12.0, 9, {"accelerometer.delay_s": 0.0004, OF_LAST_JUMP: -0.5})
    found = explain(
        fitted(data), interleaved(12.0), only=["drive_dead_time", "drive_lag", "accelerometer_lag"]
    )
    assert [one.cause for one in found.findings] == ["accelerometer_lag"]
    assert found.final.value("accelerometer.delay_s") == pytest.approx(0.0004, abs=1e-4)
