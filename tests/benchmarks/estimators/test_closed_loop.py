"""The benchmark's closed loop: its plant against theory, its oracle against the damping that was asked for."""

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from stillarm.benchmarks.estimators.closed_loop import NO_DAMPING, ORACLE, Course, run_closed
from stillarm.benchmarks.estimators.damping_table import settling_time_s
from stillarm.benchmarks.estimators.world.plant import arm_plant, rate_m_s, strike
from stillarm.benchmarks.estimators.world.regimes import CYCLE_S, REGIMES, Arm

UNIT = Arm().amplitude_m


@given(
    damping_ratio=st.floats(0.0, 0.1),
    bandwidth_hz=st.floats(5.0, 50.0),
    command=st.floats(-0.5, 0.5),
    dead_cycles=st.integers(0, 5),
)
@settings(max_examples=20, deadline=None, derandomize=True, phases=[Phase.explicit, Phase.generate])
def test_the_plant_is_its_equations(
    damping_ratio: float, bandwidth_hz: float, command: float, dead_cycles: int
) -> None:
    """Against Runge-Kutta at a twentieth of the cycle, with a command, a force and a blow."""
    arm = Arm(damping_ratio=damping_ratio)
    w, lag = arm.angular_frequency, 2 * np.pi * bandwidth_hz
    plant = arm_plant(arm, 2.0, 1.14, bandwidth_hz, dead_cycles)
    strike(plant, arm, 0.1)
    x = np.array([0.0, 0.0, 0.0, 0.1])

    def slope(x: np.ndarray, u: float) -> np.ndarray:
        bend = -2 * damping_ratio * w * x[3] - w * w * x[2] - 1.14 * 2.0 * lag * (u - x[1]) + 0.7
        return np.array([x[1], lag * (u - x[1]), x[3], bend])

    h = CYCLE_S / 20
    for cycle in range(60):
        u = command if cycle >= dead_cycles else 0.0
        plant.modal_forces_m_s2 = [0.7]
        plant.advance(command)
        for _ in range(20):
            k1 = slope(x, u)
            k2 = slope(x + 0.5 * h * k1, u)
            k3 = slope(x + 0.5 * h * k2, u)
            x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + slope(x + h * k3, u))
    found = (plant.joint_position_rad, plant.joint_velocity_rad_s, plant.deflection_m, rate_m_s(plant))
    assert found == pytest.approx(tuple(x), rel=1e-6, abs=1e-9)
    now = slope(x, command)
    assert plant.tip_acceleration_m_s2 == pytest.approx(2.0 * now[1] + now[3], rel=1e-5, abs=1e-7)
    assert plant.tip_position_m == pytest.approx(2.0 * x[0] + x[2], rel=1e-6, abs=1e-9)


def test_the_oracle_settles_as_fast_as_the_added_damping_says() -> None:
    """0.01 of the arm's and 0.12 of the joint's: ten times smaller in ln 10 / (0.13 w), give or take a half period."""
    course = Course(24.0, dict.fromkeys((0.0, 8.0, 12.0, 16.0, 20.0), UNIT), damping=lambda t: t >= 5.0)
    regime = REGIMES["freerun drift"]
    run = run_closed(ORACLE, regime, 0.3, (1,), course)
    assert settling_time_s(run, UNIT) == pytest.approx(np.log(10.0) / (0.13 * 16.34), abs=0.1)
    assert np.isnan(settling_time_s(run_closed(NO_DAMPING, regime, 0.3, (1,), course), UNIT))


def test_a_steady_random_force_keeps_up_the_amplitude_that_theory_says() -> None:
    """A white force of density S keeps up a variance of S / (4 zeta w^3)."""
    arm, random = Arm(), np.random.default_rng(1)
    force = 0.3 * UNIT * np.sqrt(4 * arm.damping_ratio * arm.angular_frequency**3 / CYCLE_S)
    plant, squares = arm_plant(arm, 2.0, 1.14, 20.0, 2), 0.0
    for cycle, push in enumerate((force * random.standard_normal(320_000)).tolist()):
        plant.modal_forces_m_s2 = [push]
        plant.advance(0.0)
        squares += plant.deflection_m**2 if cycle >= 20_000 else 0.0
    assert np.sqrt(squares / 300_000) / UNIT == pytest.approx(0.3, rel=0.15)


def test_under_a_steady_random_force_the_oracle_leaves_what_its_damping_says() -> None:
    """Variance in proportion to 1 / damping ratio: sqrt(0.01 / 0.13) of 0.3."""
    arm = Arm()
    force = 0.3 * UNIT * np.sqrt(4 * arm.damping_ratio * arm.angular_frequency**3 / CYCLE_S)
    course = Course(20.0, {}, damping=lambda t: True, force_std_m_s2=force)
    run = run_closed(ORACLE, REGIMES["freerun constant"], 0.3, (1,), course)
    left = np.sqrt(np.mean(run.deflection_m[2000:] ** 2)) / UNIT
    assert left == pytest.approx(0.3 * np.sqrt(0.01 / 0.13), rel=0.3)


def test_methods_are_shown_the_same_disturbances_and_the_truth_about_delays() -> None:
    """Before damping sets in every run is the same; the constant delay of 74 ms is off by the reading's cycle only."""
    course = Course(3.0, {0.0: UNIT, 1.5: UNIT}, damping=lambda t: t >= 2.0)
    runs = [
        run_closed(name, REGIMES["freerun constant"], 0.3, (5,), course) for name in ("correlation", ORACLE)
    ]
    assert np.array_equal(runs[0].deflection_m[:2000], runs[1].deflection_m[:2000])
    assert not np.array_equal(runs[0].deflection_m, runs[1].deflection_m)
    assert np.max(np.abs(runs[1].delay_error_s)) < 0.0006  # the oracle says 74 ms
    assert np.array_equal(runs[1].predicted_m, runs[1].deflection_m)
