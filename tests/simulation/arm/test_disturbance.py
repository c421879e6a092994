"""Strikes and random disturbance of the plant; the beam's tip slopes."""

from math import sqrt

import numpy as np
import pytest

from stillarm.common.files.model import Mode
from stillarm.common.files.scenario import Scenario, Strike
from stillarm.common.user_error import UserError
from stillarm.simulation.arm.disturbance import Disturbance
from stillarm.simulation.arm.plant import Plant
from tests.reference.plant_judge import (
    CYCLE_S,
    FIRST,
    model,
)


def test_strikes_fall_due_once_each_on_their_cycle() -> None:
    scenario = Scenario(strikes=[Strike(0.0205, 0.02), Strike(0.003, 0.01, 2), Strike(0.0, 0.005)])
    disturbance = Disturbance(scenario, 2, CYCLE_S, np.random.default_rng(0))
    fell = [
        (cycle, strike.deflection_m)
        for cycle in range(40)
        for strike in disturbance.strikes_until(cycle * CYCLE_S)
    ]
    assert fell == [(0, 0.005), (3, 0.01), (21, 0.02)]
    assert disturbance.forces_m_s2() == [0.0, 0.0]


def test_a_strike_rings_on_with_its_amplitude() -> None:
    plant = Plant(model([Mode(frequency_hz=2.6, damping_ratio=0.0)]))
    disturbance = Disturbance(Scenario(strikes=[Strike(0.01, -0.006)]), 1, CYCLE_S, np.random.default_rng(0))
    seen = []
    for cycle in range(500):
        disturbance.act_on(plant, cycle * CYCLE_S)
        plant.advance(0.0)
        seen.append(plant.deflection_m)
    assert max(map(abs, seen)) == pytest.approx(0.006, rel=1e-4)
    assert seen[20] < 0.0


def test_a_strike_on_a_mode_that_is_not_there_is_refused() -> None:
    with pytest.raises(UserError, match=r"^scenario: strikes\[0\]\.mode = 3: [^\n]*1 to 2[^\n]*$"):
        Disturbance(Scenario(strikes=[Strike(1.0, 0.01, 3)]), 2, CYCLE_S, np.random.default_rng(0))
    with pytest.raises(IndexError):
        Plant(model([FIRST])).strike(0, 0.01)


@pytest.mark.parametrize("cycle_s", [0.001, 0.004])
def test_random_disturbance_is_white_with_the_stated_level_at_1_khz(cycle_s: float) -> None:
    scenario = Scenario(random_disturbance_m_s2=0.2)
    drawn = Disturbance(scenario, 2, cycle_s, np.random.default_rng(3))
    again = Disturbance(scenario, 2, cycle_s, np.random.default_rng(3))
    forces = np.array([drawn.forces_m_s2() for _ in range(20000)])
    assert np.array_equal(forces[:3000], [again.forces_m_s2() for _ in range(3000)])
    level = 0.2 * sqrt(0.001 / cycle_s)
    assert np.std(forces, axis=0) == pytest.approx([level, level], rel=0.03)
    assert abs(np.corrcoef(forces[1:, 0], forces[:-1, 0])[0, 1]) < 0.03
    assert abs(np.corrcoef(forces.T)[0, 1]) < 0.03
