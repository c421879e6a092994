"""Friction takes the same off every steady velocity."""

import pytest

from tests.fixtures.driven_joint import rig, velocities


@pytest.mark.parametrize(
    ("command", "steady"), [(0.015, 0.0), (-0.015, 0.0), (0.02, 0.0), (0.021, 0.001), (-0.3, -0.28)]
)
def test_steady_velocities_of_both_signs(command: float, steady: float) -> None:
    joint = rig({"cause": "joint_friction", "velocity_loss_rad_s": 0.02})
    assert velocities(joint, [command] * 400)[-1] == pytest.approx(steady, abs=1e-12)
