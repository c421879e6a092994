"""Several effects of the drive at once, and those of no size."""

from math import exp, pi

import pytest

from stillarm.common.files.effects import declared
from stillarm.common.files.model import Model
from tests.fixtures.driven_joint import rig, velocities
from tests.reference.plant_judge import moves


def test_dead_time_lag_and_saturation_answer_a_step_as_their_formulas_say() -> None:
    """v(t) = c (1 - exp(-lag (t - dead time))) for c within the limit."""
    effects = (
        {"cause": "drive_dead_time", "dead_time_s": 0.0205},
        {"cause": "drive_lag", "bandwidth_hz": 4.0},
        {"cause": "drive_saturation", "max_velocity_rad_s": 0.1},
    )
    found = velocities(rig(*effects), [0.4] * 200)
    wanted = [0.1 * max(0.0, 1.0 - exp(-2.0 * pi * 4.0 * (0.001 * n - 0.0205))) for n in range(1, 201)]
    assert found == pytest.approx(wanted, abs=1e-12)


def test_no_size_no_effect() -> None:
    commands = moves(300, 0.3).tolist()
    none = (
        {"cause": "drive_deadband", "deadband_rad_s": 0.0},
        {"cause": "joint_friction", "velocity_loss_rad_s": 0.0},
        {"cause": "gear_backlash", "gap_rad": 0.0},
        {"cause": "drive_dead_time", "dead_time_s": 0.0},
    )
    assert velocities(rig(*none), commands) == velocities(rig(), commands)
    assert declared(Model(effects=[none[3]])).effects == []  # type: ignore[list-item]
