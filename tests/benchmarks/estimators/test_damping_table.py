"""The second table's random force."""

import numpy as np
import pytest

from stillarm.benchmarks.estimators.closed_loop import ORACLE, Course, run_closed
from stillarm.benchmarks.estimators.world.plant import arm_plant
from stillarm.benchmarks.estimators.world.regimes import CYCLE_S, REGIMES, Arm

UNIT = Arm().amplitude_m


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
