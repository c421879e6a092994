"""A linear arm's cycle by its matrix, beside the same cycle by the stepper."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from stillarm.common.files.model import Drive
from stillarm.simulation.arm.compiled_laws import laws_of
from stillarm.simulation.arm.free_run import free_run
from stillarm.simulation.arm.linear_run import linear_joint
from stillarm.simulation.arm.state import Records, make_arm

Array = NDArray[np.float64]

DT, CYCLES = 0.001, 800
JUMPS_AT = np.array([0, 300], dtype=np.int64)


def drive_of(bandwidth_hz: float = 20.0, dead_s: float = 0.0023, most: float = 1e3) -> Drive:
    return Drive(
        bandwidth_hz=bandwidth_hz,
        dead_time_s=dead_s,
        max_velocity_rad_s=1e9,
        max_acceleration_rad_s2=most,
        min_position_rad=-10.0,
        max_position_rad=10.0,
    )


def command_of(seed: int) -> Array:
    return np.repeat(np.random.default_rng(seed).normal(0.0, 0.3, CYCLES // 100), 100)


def run_of(arm: Records, whole: int, command: Array, jumps: Array) -> list[Array]:
    modes = jumps.shape[1]
    outs = [np.zeros((CYCLES, width)) for width in (4, 2, modes, modes)]
    free_run(arm, command, whole, JUMPS_AT, jumps, *outs)
    return outs


def is_linear(drive: Drive, command: Array, gap: float = 0.0) -> bool:
    arm, whole = make_arm(drive, DT, np.array([[2.6, 0.01, 1.3]]), laws_of([], 0.0), gap)
    return bool(
        linear_joint(arm, command, whole, np.zeros((CYCLES, 4)), np.zeros((CYCLES, 2)), np.zeros((CYCLES, 2)))
    )


@settings(max_examples=25, deadline=None)
@given(
    hz=st.floats(0.5, 40.0),
    damping=st.floats(0.0, 0.2),
    push=st.floats(-2.0, 2.0),
    bandwidth_hz=st.floats(5.0, 60.0),
    dead_s=st.floats(0.0, 0.01),
    seed=st.integers(0, 1000),
)
def test_it_moves_as_the_stepper_does(
    hz: float, damping: float, push: float, bandwidth_hz: float, dead_s: float, seed: int
) -> None:
    modes = np.array([[hz, damping, push], [3.7 * hz, damping, -0.3 * push]])
    drive, command = drive_of(bandwidth_hz, dead_s), command_of(seed)
    jumps = np.array([[[0.02, 0.3], [1e-3, 0.0]], [[0.0, 0.1], [0.0, 0.05]]])
    found = []
    for stepped in (False, True):
        arm, whole = make_arm(drive, DT, modes, laws_of([], 0.0))
        if stepped:
            arm["c2"] = 1e-300  # a force of no size: the stepper has to look at it
        found.append(run_of(arm, whole, command, jumps))
    for mine, judge in zip(*found, strict=True):
        scale = max(float(np.max(np.abs(judge))), 1e-9)
        assert np.max(np.abs(mine - judge)) < 1e-10 * scale


@pytest.mark.parametrize(
    ("what", "drive", "gap"),
    [
        ("a limit of acceleration", drive_of(most=5.0), 0.0),
        ("play", drive_of(), 1e-3),
    ],
)
def test_what_is_not_linear_is_left_to_the_stepper(what: str, drive: Drive, gap: float) -> None:
    assert is_linear(drive_of(), command_of(1))
    assert not is_linear(drive, command_of(1), gap), what


def test_an_end_stop_is_left_to_the_stepper() -> None:
    assert not is_linear(drive_of(), np.full(CYCLES, 30.0))
