"""The plant's end stops and limits, and what holds for any arm: energy, linearity."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from stillarm.common.files.model import Drive, Mode
from stillarm.simulation.arm.plant import Plant
from tests.reference.plant_judge import FIRST, LENGTH_M, Array, model, moves, run


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_end_stop_halts_the_joint_and_strikes_the_arm(direction: float) -> None:
    plant = Plant(model([FIRST], Drive(dead_time_s=0.0, min_position_rad=-0.05, max_position_rad=0.05)))
    ours = run(plant, np.full(200, direction * 0.4))
    assert (plant.joint_position_rad, plant.joint_velocity_rad_s) == (direction * 0.05, 0.0)
    assert plant.joint_acceleration_rad_s2 == 0.0

    w, lag = 2.0 * pi * 2.6, 2.0 * pi * 20.0

    def slope(time: float, state: Array, moving: bool) -> list[float]:
        joint = float(np.clip(lag * (direction * 0.4 - state[1]), -20.0, 20.0)) if moving else 0.0
        bend = -w * w * state[2] - 0.02 * w * state[3] - 1.14 * LENGTH_M * joint
        return [state[1], joint, state[3], bend]

    def at_stop(time: float, state: Array, moving: bool) -> float:
        return float(abs(state[0]) - 0.05)

    at_stop.terminal = True  # type: ignore[attr-defined]
    options = {"rtol": 1e-10, "atol": 1e-13, "method": "DOP853"}
    free = solve_ivp(slope, (0.0, 0.2), np.zeros(4), args=(True,), events=at_stop, max_step=0.001, **options)
    position, velocity, deflection, rate = free.y[:, -1]
    # the joint's velocity jumps to zero: theta'' is an impulse, which the arm feels as any other theta''
    struck = np.array([position, 0.0, deflection, rate + 1.14 * LENGTH_M * velocity])
    rest = solve_ivp(slope, (free.t[-1], 0.2), struck, args=(False,), **options)
    assert 0.1 < free.t[-1] < 0.15
    assert ours[-1] == pytest.approx(rest.y[:, -1], rel=1e-7)

    for _ in range(20):
        plant.advance(-direction * 0.4)
    assert direction * plant.joint_velocity_rad_s < -0.3
    assert abs(plant.joint_position_rad) < 0.05


def test_a_joint_that_turns_just_beyond_a_stop_within_a_cycle_still_hits_it() -> None:
    drive = Drive(bandwidth_hz=300.0, dead_time_s=0.0, max_acceleration_rad_s2=1e4)
    free = Plant(model([FIRST], drive))
    free.advance(0.5)
    free.advance(0.5)
    velocity, position = free.joint_velocity_rad_s, free.joint_position_rad
    free.advance(-0.5)
    assert velocity > 0.0 > free.joint_velocity_rad_s
    stop = position + 1e-5  # passed within the cycle, at the end of which the free joint is back below it
    assert free.joint_position_rad < stop
    stopped = Plant(
        model(
            [FIRST],
            Drive(bandwidth_hz=300.0, dead_time_s=0.0, max_acceleration_rad_s2=1e4, max_position_rad=stop),
        )
    )
    for command in (0.5, 0.5, -0.5):
        stopped.advance(command)
    assert stopped.joint_position_rad < free.joint_position_rad
    assert stopped.joint_velocity_rad_s < 0.0


def test_the_joint_starts_at_the_stop_nearest_to_zero() -> None:
    plant = Plant(model([FIRST], Drive(min_position_rad=0.1, max_position_rad=0.4)))
    assert plant.joint_position_rad == 0.1


modes_strategy = st.lists(
    st.builds(
        Mode,
        frequency_hz=st.floats(0.1, 400.0),
        damping_ratio=st.floats(0.0, 0.95),
        participation=st.floats(-2.0, 2.0),
    ),
    min_size=1,
    max_size=3,
)


@settings(max_examples=60, deadline=None)
@given(modes_strategy, st.floats(-0.1, 0.1))
def test_energy_never_grows_without_input(modes: list[Mode], struck_m: float) -> None:
    plant = Plant(model(modes))
    for number in range(1, len(modes) + 1):
        plant.strike(number, struck_m)
    stiffness = [mode.angular_frequency**2 for mode in modes]
    previous = [rate**2 for rate in plant.modal_rates_m_s]
    for _ in range(200):
        plant.advance(0.0)
        energy = [
            rate**2 + k * q**2
            for rate, q, k in zip(plant.modal_rates_m_s, plant.modal_deflections_m, stiffness, strict=True)
        ]
        assert all(
            now <= before * (1.0 + 1e-12) + 1e-290 for now, before in zip(energy, previous, strict=True)
        )
        previous = energy


@settings(max_examples=30, deadline=None)
@given(modes_strategy, st.integers(0, 2**32 - 1), st.floats(-3.0, 3.0), st.floats(0.0, 0.01))
def test_linear_while_no_limit_is_met(
    modes: list[Mode], seed: int, factor: float, dead_time_s: float
) -> None:
    drive = Drive(dead_time_s=dead_time_s, max_velocity_rad_s=100.0, max_acceleration_rad_s2=1e6)
    first, second = moves(80, 0.2, seed), moves(80, 0.2, seed + 1)
    a, b, both = (run(Plant(model(modes, drive)), c) for c in (first, second, first + factor * second))
    scale = np.max(np.abs(a), axis=0) + np.max(np.abs(factor * b), axis=0)
    assert np.all(np.abs(both - (a + factor * b)) <= 1e-10 * scale + 1e-14)


@settings(max_examples=60, deadline=None)
@given(
    st.floats(0.5, 1000.0),
    st.floats(0.0, 0.02),
    st.floats(0.01, 5.0),
    st.floats(0.1, 1000.0),
    st.lists(st.floats(-1e9, 1e9), min_size=1, max_size=60),
)
def test_limits_hold_whatever_is_commanded(
    bandwidth_hz: float, dead_time_s: float, velocity: float, acceleration: float, commands: list[float]
) -> None:
    drive = Drive(
        bandwidth_hz=bandwidth_hz,
        dead_time_s=dead_time_s,
        max_velocity_rad_s=velocity,
        max_acceleration_rad_s2=acceleration,
        min_position_rad=-0.002,
        max_position_rad=0.003,
    )
    plant = Plant(model([FIRST], drive))
    for command in commands:
        plant.advance(command)
        assert -0.002 <= plant.joint_position_rad <= 0.003
        assert abs(plant.joint_velocity_rad_s) <= velocity * (1.0 + 1e-9)
        assert abs(plant.joint_acceleration_rad_s2) <= acceleration * (1.0 + 1e-9)
        assert np.isfinite(plant.tip_acceleration_m_s2)


def test_a_command_that_is_no_number_is_an_error() -> None:
    with pytest.raises(ValueError, match="not a number"):
        Plant(model([FIRST])).advance(float("nan"))
