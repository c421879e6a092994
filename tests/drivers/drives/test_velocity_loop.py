"""The velocity loop around an arm from its mass matrix (tests/reference/torque_arm.py, by scipy)."""

from math import inf, isnan, nan, pi
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.files.model import Mode, Model, load_model
from stillarm.common.user_error import UserError
from stillarm.drivers.drives.drive import JointState
from stillarm.drivers.drives.velocity_loop import OLDEST_STATE_S, VelocityLoop
from tests.fixtures.torque_model import FIRST, SECOND, torque_model
from tests.reference.torque_arm import TorqueArm

CYCLE_S = 1e-3
PLAIN = {"viscous_n_m_s": 0.5, "amplifier_lag_s": 0.001, "dead_time_s": 0.0, "bandwidth_hz": 10.0}


def looped(assumed: Model, true: Model, commands: np.ndarray, encoder: float = 1.0) -> np.ndarray:
    """theta' before each cycle. encoder: what the encoder makes of theta'."""
    loop, arm = VelocityLoop(assumed), TorqueArm(true)
    rates = []
    for command in commands:
        rates.append(arm.state[1])
        state = JointState(encoder * arm.state[0], encoder * arm.state[1], 0.0)
        value = loop.input_for(command, state)
        if isnan(value):
            break
        arm.advance(value)
    return np.array(rates)


def first_order(commands: np.ndarray, model: Model) -> np.ndarray:
    """theta' as the model file states it of a drive: a lag of bandwidth_hz behind the command."""
    rate, rates = 0.0, []
    for command in commands:
        rates.append(rate)
        rate += (1.0 - np.exp(-2.0 * pi * model.drive.bandwidth_hz * CYCLE_S)) * (command - rate)
    return np.array(rates)


def test_the_joint_follows_as_the_model_file_says_of_every_drive() -> None:
    model = torque_model(Mode(modal_mass_kg=0.01), **PLAIN)
    commands = 0.2 * np.sin(2.0 * pi * 1.0 * np.arange(1000) * CYCLE_S)
    rates, stated = looped(model, model, commands), first_order(commands, model)
    late = 2  # cycles: half of one for the held input, and the amplifier's lag
    assert np.abs(rates[late:] - stated[:-late]).max() < 0.02 * 0.2


def test_what_the_arm_pulls_at_the_joint_is_held_against() -> None:
    """A struck arm that carries two thirds of the inertia: the joint moves less than a fifth of a free hub's."""
    model = torque_model(FIRST, **PLAIN)

    def strike(loop: VelocityLoop | None) -> float:
        arm, most = TorqueArm(model), 0.0
        arm.state[4] = 0.1
        for _ in range(400):
            value = loop.input_for(0.0, JointState(arm.state[0], arm.state[1], 0.0)) if loop else 0.0
            arm.advance(value)
            most = max(most, abs(arm.state[1]))
        return most

    assert strike(VelocityLoop(model)) < 0.3 * strike(None)


def test_a_constant_torque_that_no_model_states_is_compensated() -> None:
    model = torque_model(Mode(modal_mass_kg=0.01), **PLAIN)
    loop, arm = VelocityLoop(model), TorqueArm(model)
    for _ in range(1500):
        arm.advance(loop.input_for(0.1, JointState(arm.state[0], arm.state[1], 0.0)) + 4.0)
    assert arm.state[1] == pytest.approx(0.1, abs=1e-3)


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(
    carried=st.floats(0.0, 0.9),
    frequency_hz=st.floats(0.5, 60.0),
    bandwidth_hz=st.floats(1.0, 200.0),
    lag_s=st.floats(0.0005, 0.005),
    wrong=st.floats(0.7, 1.5),
)
def test_no_arm_is_made_unstable(
    carried: float, frequency_hz: float, bandwidth_hz: float, lag_s: float, wrong: float
) -> None:
    """Whatever share of the inertia the mode carries, and with an inertia that is stated wrongly."""
    mass = max(carried, 1e-4) * 12.0 / (1.14 * 2.0) ** 2
    mode = Mode(frequency_hz=frequency_hz, damping_ratio=0.003, participation=1.14, modal_mass_kg=mass)
    drive = {"viscous_n_m_s": 0.0, "bandwidth_hz": bandwidth_hz, "amplifier_lag_s": lag_s, "dead_time_s": 0.0}
    stated_mode = Mode(
        frequency_hz=frequency_hz, damping_ratio=0.003, participation=1.14, modal_mass_kg=mass * wrong
    )
    true, assumed = (
        torque_model(mode, **drive),
        torque_model(stated_mode, inertia_kg_m2=12.0 * wrong, **drive),
    )
    commands = np.where(np.arange(8000) < 100, 0.1, 0.0)  # eight periods of the slowest loop
    rates = looped(assumed, true, commands)
    assert len(rates) == len(commands)
    assert np.abs(rates[-2000:]).max() < 0.5 * np.abs(rates[:3000]).max() + 1e-6


@pytest.mark.parametrize("state", [JointState(0.0, 0.1, OLDEST_STATE_S * 1.01), JointState(nan, nan, inf)])
def test_without_a_fresh_report_it_asks_to_brake(state: JointState) -> None:
    loop = VelocityLoop(torque_model(**PLAIN))
    assert isnan(loop.input_for(0.1, state))
    assert not loop.tripped
    assert loop.input_for(0.0, JointState(0.0, 0.0, 0.0)) == 0.0


@pytest.mark.parametrize("command", [0.1, 0.0])
def test_an_encoder_with_the_wrong_sign_trips_it_for_good(command: float) -> None:
    model = torque_model(FIRST, SECOND, **PLAIN)
    commands = np.full(3000, command)
    commands[0] = 0.1  # something has to disturb a joint at rest
    rates = looped(model, model, commands, encoder=-1.0)
    assert len(rates) < 1500
    assert np.abs(rates).max() < 3.0 * model.drive.max_velocity_rad_s


def test_a_tripped_loop_goes_on_after_a_reset_only() -> None:
    loop = VelocityLoop(torque_model(**PLAIN))
    assert isnan(loop.input_for(0.1, JointState(0.0, 9.0, 0.0)))
    assert loop.tripped
    assert isnan(loop.input_for(0.0, JointState(0.0, 0.0, 0.0)))
    loop.reset()
    assert loop.input_for(0.1, JointState(0.0, 0.0, 0.0)) > 0.0


def test_the_integral_does_not_wind_up_at_the_limit() -> None:
    model = torque_model(Mode(modal_mass_kg=0.01), input_limit=2.0, **PLAIN)
    commands = np.where(np.arange(2500) < 800, 0.5, 0.0)
    rates = looped(model, model, commands)
    overshoot = -rates.min()
    assert overshoot < 0.1 * rates.max()


def test_the_input_is_in_the_drive_s_unit_and_within_its_limit() -> None:
    model = torque_model(FIRST, kind="current", torque_per_input=-0.5, input_limit=3.0, **PLAIN)
    value = VelocityLoop(model).input_for(0.6, JointState(0.0, 0.0, 0.0))
    assert value == -3.0


def test_an_input_without_a_limit_is_refused() -> None:
    drive = msgspec.structs.replace(torque_model(FIRST).drive, input_limit=msgspec.UNSET)
    with pytest.raises(UserError, match=r"m\.toml: drive\.input_limit: needed"):
        VelocityLoop(msgspec.structs.replace(torque_model(FIRST), drive=drive), "m.toml")


def test_a_bandwidth_beyond_the_cycle_s_own_is_followed_within_a_cycle() -> None:
    model = torque_model(Mode(modal_mass_kg=0.01), **{**PLAIN, "bandwidth_hz": 900.0})
    rates = looped(model, model, np.full(300, 0.1))
    assert rates[-1] == pytest.approx(0.1, rel=0.01) and rates.max() < 0.13


def test_a_joint_that_follows_velocities_has_no_loop() -> None:
    with pytest.raises(ValueError, match="needs no loop"):
        VelocityLoop(Model())


def test_the_program_s_example_has_a_loop() -> None:
    model = load_model(Path(__file__).parents[3] / "configs" / "model_torque.toml")
    assert VelocityLoop(model).input_for(0.1, JointState(0.0, 0.0, 0.0)) > 0.0
