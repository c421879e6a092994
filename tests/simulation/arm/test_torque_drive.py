"""The arm under a drive's input, against its mass matrix and a matrix exponential, and against plain statements."""

from collections.abc import Callable
from math import cos, nan, sin

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stillarm.common.files.model import Mode, Model
from stillarm.common.user_error import UserError
from stillarm.simulation.arm.plant import Plant
from tests.fixtures.torque_model import FIRST, torque_model
from tests.reference.torque_arm import TorqueArm

WIDE = {"min_position_rad": -10.0, "max_position_rad": 10.0, "dead_time_s": 0.0}


def run(model: Model, inputs: np.ndarray) -> np.ndarray:
    """theta, theta', theta'', q_i after each cycle."""
    plant = Plant(model)
    rows = []
    for value in inputs:
        plant.advance(value)
        joint = plant.joint_position_rad, plant.joint_velocity_rad_s, plant.joint_acceleration_rad_s2
        rows.append([*joint, *plant.modal_deflections_m])
    return np.array(rows)


def test_the_coupled_motion_is_that_of_the_mass_matrix() -> None:
    model = torque_model(viscous_n_m_s=2.0, amplifier_lag_s=0.002, **WIDE)
    time_s = np.arange(1500) * 1e-3
    inputs = 5.0 * np.sin(2.0 * np.pi * 1.3 * time_s) + 3.0 * (time_s > 0.5)
    peer, rows = TorqueArm(model), []
    for value in inputs:
        peer.advance(value)
        joint_acceleration = peer.derivative(peer.state, value)[1]
        rows.append([*peer.state[:2], joint_acceleration, *peer.state[3:5]])
    theirs = np.array(rows)
    error = np.abs(run(model, inputs) - theirs).max(axis=0) / np.abs(theirs).max(axis=0)
    assert error.max() < 2e-5, error


def test_a_free_joint_vibrates_at_the_higher_frequency_of_a_free_hub() -> None:
    """w sqrt(1 + (modal inertia) / J_hub), Cannon and Schmitz."""
    plant = Plant(torque_model(FIRST, **WIDE))
    carried = 1.5 * (1.14 * 2.0) ** 2
    plant.strike(1, 0.01)
    bent = []
    for _ in range(2000):
        plant.advance(0.0)
        bent.append(plant.deflection_m)
    crossings = np.count_nonzero(np.diff(np.signbit(bent)))
    expected = 2.6 * np.sqrt(1.0 + carried / (12.0 - carried))
    assert crossings / 4.0 == pytest.approx(expected, abs=0.25)


@pytest.mark.parametrize("share", [0.5, 0.99])
def test_dry_friction_holds_the_joint_as_far_as_it_goes(share: float) -> None:
    moved = run(torque_model(FIRST, coulomb_n_m=3.0, **WIDE), np.full(300, 3.0 * share))
    assert np.abs(moved[:, 0]).max() < 1e-12
    assert np.abs(moved[:, 2]).max() < 1e-9


def test_more_than_dry_friction_moves_it() -> None:
    moved = run(torque_model(FIRST, coulomb_n_m=3.0, **WIDE), np.full(300, 3.3))
    rigid = 0.5 * 0.3 / 12.0 * 0.3**2
    assert moved[-1, 0] == pytest.approx(rigid, rel=0.5)


def test_the_input_is_limited_in_its_own_unit_and_sign() -> None:
    reversed_drive = {"kind": "current", "torque_per_input": -2.0, "input_limit": 1.5, **WIDE}
    limited = run(torque_model(FIRST, **reversed_drive), np.full(100, 9.0))
    plain = run(torque_model(FIRST, **WIDE), np.full(100, -3.0))
    np.testing.assert_allclose(limited, plain, rtol=1e-12)


def test_an_input_that_is_no_number_brakes() -> None:
    model = torque_model(Mode(modal_mass_kg=0.01), **WIDE)
    inputs = np.concatenate((np.full(200, 20.0), np.full(400, nan)))
    rate = run(model, inputs)[:, 1]
    assert rate[199] > 0.2
    assert np.abs(rate[-100:]).max() < 0.1 * rate[199]


def test_an_end_stop_stops_the_joint() -> None:
    model = torque_model(FIRST, min_position_rad=-1.0, max_position_rad=0.05)
    moved = run(model, np.full(1500, 20.0))
    assert moved[:, 0].max() == 0.05
    assert moved[-1, 1] == 0.0


def test_play_behind_the_motor_leaves_the_arm_alone_until_it_is_crossed() -> None:
    model = torque_model(FIRST, gear_play_rad=0.01, **WIDE)
    moved = run(model, np.full(200, 2.0))
    motor = 0.5 * 2.0 / (12.0 - 1.5 * 2.28**2) * (np.arange(1, 201) * 1e-3) ** 2
    before = motor < 0.005
    assert np.all(moved[before, 0] == 0.0)
    assert moved[-1, 0] > 0.0


def test_an_effect_on_velocity_commands_is_refused() -> None:
    model = torque_model(FIRST)
    deadband = {"cause": "drive_deadband", "deadband_rad_s": 0.01}
    with pytest.raises(UserError, match=r'm\.toml: effects: one of them acts on velocity commands.*"torque"'):
        Plant(Model(arm=model.arm, drive=model.drive, effects=[deadband]), "m.toml")


def with_effects(*effects: dict[str, str | float]) -> Model:
    model = torque_model(Mode(modal_mass_kg=0.0001), **WIDE)
    return Model(arm=model.arm, drive=model.drive, effects=list(effects))


def rigid_peer(torque: Callable[[float, float, float], float], seconds: float) -> tuple[float, float]:
    """theta and theta' of a rigid joint of 12 kg m^2 under a torque of (t, theta, theta'), by scipy."""
    solved = solve_ivp(
        lambda t, y: [y[1], torque(t, y[0], y[1]) / 12.0], (0.0, seconds), [0.0, 0.0], rtol=1e-9, atol=1e-12
    )
    return solved.y[0, -1], solved.y[1, -1]


@pytest.mark.parametrize(
    ("effects", "torque"),
    [
        (
            [{"cause": "torque_ripple", "sine_rad_s2": 0.1, "cosine_rad_s2": 0.3, "cycles_per_rad": 20.0}],
            lambda t, theta, omega: 4.0 + 12.0 * (0.1 * sin(20.0 * theta) + 0.3 * cos(20.0 * theta)),
        ),
        (
            [
                {"cause": "gravity_load", "sine_rad_s2": -2.0},
                {"cause": "torque_offset", "offset_rad_s2": 0.1},
            ],
            lambda t, theta, omega: 4.0 + 12.0 * (0.1 - 2.0 * sin(theta)),
        ),
        (
            [{"cause": "joint_viscous_friction", "damping_per_s": 2.0, "square_per_rad": 0.5}],
            lambda t, theta, omega: 4.0 - 12.0 * (2.0 + 0.5 * abs(omega)) * omega,
        ),
        (
            [{"cause": "joint_coulomb_friction", "coulomb_rad_s2": 0.1, "difference_rad_s2": 0.05}],
            lambda t, theta, omega: 4.0 - 12.0 * 0.15,
        ),
        ([{"cause": "amplifier_dead_zone", "dead_zone": 1.5}], lambda t, theta, omega: 2.5),
        ([{"cause": "amplifier_dead_zone", "dead_cut": 3.0}], lambda t, theta, omega: 4.0),
        ([{"cause": "amplifier_dead_zone", "dead_cut": 5.0}], lambda t, theta, omega: 0.0),
    ],
)
def test_a_declared_effect_of_the_joint_acts_by_its_equation(
    effects: list[dict[str, str | float]], torque: Callable[[float, float, float], float]
) -> None:
    moved = run(with_effects(*effects), np.full(800, 4.0))
    np.testing.assert_allclose(moved[-1, :2], rigid_peer(torque, 0.8), rtol=1e-3, atol=1e-9)


def test_an_effect_on_a_driven_joint_s_sensor_is_refused_in_one_line() -> None:
    with pytest.raises(
        UserError, match=r"m\.toml: effects\[0\]\.cause = 'sensor_lag': only `stillarm diagnose`"
    ):
        Plant(with_effects({"cause": "sensor_lag", "lag_s": 0.01, "channel": "joint_position_rad"}), "m.toml")
