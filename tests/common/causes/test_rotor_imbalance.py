"""An arm that is shaken by its own motor: as theory says, and named by a search."""

from math import pi

import numpy as np
import pytest

from stillarm.common.causes.rotor_imbalance import law
from stillarm.common.files.model import Arm, Drive, Mode, Model
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision.explain import explain
from stillarm.simulation.arm.plant import Plant
from tests.fixtures.synthetic import fitted, measured


def test_the_force_grows_with_the_square_of_the_speed_and_ends_at_rest() -> None:
    def force(theta: float, omega: float) -> float:
        return law(0.0, theta, omega, 0.0, 0.0, 16.0, 80.0, 3e-4, 0.4)

    assert force(0.3, 0.0) == 0.0
    assert force(0.3, 0.2) == pytest.approx(4.0 * force(0.3, 0.1))
    assert force(0.3 + 2.0 * pi / 80.0, 0.2) == pytest.approx(force(0.3, 0.2))


def test_a_joint_at_constant_speed_shakes_the_arm_as_a_sine_does() -> None:
    """Amplitude F / sqrt((w^2 - s^2)^2 + (2 zeta w s)^2) at the motor's speed s, once the start has died away."""
    ratio, speed, imbalance = 60.0, 0.15, 5e-4
    effect = {"cause": "rotor_imbalance", "gear_ratio": ratio, "imbalance_m": imbalance}
    drive = Drive(max_position_rad=1e3)
    arm = Arm(length_m=2.0, modes=[Mode(damping_ratio=0.1)])
    plant = Plant(Model(arm=arm, drive=drive, effects=[effect]))
    shown = []
    for _ in range(14000):
        plant.advance(speed)
        shown.append(plant.deflection_m)
    w, s = 2.0 * pi * 2.6, ratio * speed
    wanted = imbalance * s**2 / np.hypot(w**2 - s**2, 2.0 * 0.1 * w * s)
    assert np.max(np.abs(shown[-3000:])) == pytest.approx(wanted, rel=1e-3)


@pytest.mark.slow
def test_a_search_names_it_and_finds_its_size() -> None:
    true = {"rotor_imbalance.gear_ratio": 70.0, "rotor_imbalance.imbalance_m": 6e-4}
    data = measured(6.0, 3, true)
    rivals = ["rotor_imbalance", "periodic_disturbance", "cubic_stiffness", "gear_backlash", "joint_friction"]
    found = explain(fitted(data), interleaved(6.0), only=rivals)
    assert [one.cause for one in found.findings] == ["rotor_imbalance"]
    for name, value in true.items():
        assert found.final.value(name) == pytest.approx(value, abs=4.0 * found.final.std[name])
        assert found.final.value(name) == pytest.approx(value, rel=0.1)
