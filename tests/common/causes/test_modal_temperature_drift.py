"""An arm that warms up: its frequency where the law says, and named by a search beside a steady drift."""

from math import exp

import numpy as np
import pytest

from stillarm.common.causes.modal_temperature_drift import law
from stillarm.common.files.model import Arm, Mode, Model
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision.explain import explain
from stillarm.simulation.arm.plant import Plant
from tests.fixtures.synthetic import fitted, measured


def test_the_frequency_levels_off() -> None:
    assert law(0.0, 0.0, 2.6, 20.0, -0.04, 0.5) == 1.0
    assert law(20.0, 0.0, 2.6, 20.0, -0.04, 0.5) == pytest.approx(1.0 - 0.04 * (1.0 - exp(-1.0)))
    assert law(1e4, 1.0, 2.6, 20.0, -0.04, 0.5) == pytest.approx(0.98)


def test_the_arm_rings_at_it() -> None:
    """Zero crossings at the end of a long ring-down, against those at its beginning."""
    effect = {"cause": "modal_temperature_drift", "time_constant_s": 1.0, "relative_change": 0.1}
    plant = Plant(Model(arm=Arm(length_m=2.0, modes=[Mode(damping_ratio=0.0)]), effects=[effect]))
    plant.strike(1, 0.01)
    shown = []
    for _ in range(20000):
        plant.advance(0.0)
        shown.append(plant.deflection_m)
    late = np.array(shown[10000:])
    up = np.flatnonzero((late[:-1] < 0.0) & (late[1:] >= 0.0))
    crossings = up - late[up] / (late[up + 1] - late[up])
    assert 1000.0 / np.mean(np.diff(crossings)) == pytest.approx(2.6 * 1.1, rel=1e-4)


@pytest.mark.slow
def test_a_search_names_it_and_finds_its_size() -> None:
    true = {"modal_temperature_drift.time_constant_s": 4.0, "modal_temperature_drift.relative_change": -0.012}
    data = measured(10.0, 3, true)
    rivals = ["modal_temperature_drift", "stiffness_drift", "payload_change", "cubic_stiffness"]
    found = explain(fitted(data), interleaved(10.0), only=rivals)
    # a form of the mechanism that the contract knows
    assert [(one.cause, one.form) for one in found.findings] == [("stiffness_drift", "that levels off")]
    for name, value in true.items():
        assert found.final.value(name) == pytest.approx(value, abs=4.0 * found.final.std[name])
        assert found.final.value(name) == pytest.approx(value, rel=0.1)
