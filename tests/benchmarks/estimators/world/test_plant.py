"""The benchmark's arm is its equations."""

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from stillarm.benchmarks.estimators.world.plant import arm_plant, rate_m_s, strike
from stillarm.benchmarks.estimators.world.regimes import CYCLE_S, Arm


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
    """Against Runge-Kutta at a twentieth of the cycle, with a command, a force and an impact."""
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
