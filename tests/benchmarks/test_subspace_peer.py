"""The plain subspace fit, on an oscillator that scipy simulates, and on the measured flexible arm."""

import numpy as np
import pytest
from scipy.signal import cont2discrete, dlsim

from stillarm.benchmarks.identification_data import f16, robot_arm, silverbox
from stillarm.benchmarks.identification_driven import as_driven
from stillarm.benchmarks.subspace_peer import best_subspace
from tests.conftest import DATA


def test_a_linear_oscillator_is_foretold_from_its_input() -> None:
    generator, step = np.random.default_rng(3), 0.01
    w, zeta = 12.0, 0.02
    a, b = np.array([[0.0, 1.0], [-w * w, -2.0 * zeta * w]]), np.array([[0.0], [1.0]])
    system = cont2discrete((a, b, np.array([[1.0, 0.0]]), np.zeros((1, 1))), step)
    u = generator.standard_normal(3000)
    _, y, _ = dlsim((*system[:4], step), u)
    y = y[:, 0] + 1e-3 * np.std(y) * generator.standard_normal(3000) + 2.0
    shown, order = best_subspace(u, y, slice(0, 2000), slice(2000, 3000))
    assert order >= 2
    assert np.std(shown - y[2000:]) < 0.02 * np.std(y)


@pytest.mark.hardware_data
@pytest.mark.slow
@pytest.mark.skipif(not (DATA / "robot_arm").is_dir(), reason="../shared/data is not there")
def test_the_measured_pairs_are_read_and_the_flexible_arm_is_nearly_linear() -> None:
    pair = robot_arm(DATA)
    assert pair is not None and silverbox(DATA) is not None and f16(DATA) is not None
    shown, order = best_subspace(pair.u, pair.y, pair.train, pair.test)
    y = pair.y[pair.test]
    assert order >= 6
    assert np.std(shown - y) < 0.03 * np.std(y)
    ours, said = as_driven(pair)
    assert np.std(ours - y) < 0.03 * np.std(y)
    assert said.endswith("no cause; linear, with 3 modes")


def test_what_is_not_there_is_none() -> None:
    folder = DATA / "nothing of that name"
    assert silverbox(folder) is None and robot_arm(folder) is None and f16(folder) is None
