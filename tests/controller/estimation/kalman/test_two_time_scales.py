"""The whole state over a time, at once or in steps."""

import numpy as np
import pytest

from tests.fixtures.kalman_space import space


def test_the_whole_state_composes() -> None:
    """Over 30 ms at once or in three steps: the same transition and the same scatter."""
    model = space(1.0)
    phi, added = np.eye(model.size), np.zeros((model.size, model.size))
    for step in (0.004, 0.015, 0.011):
        one = model.transition(step)
        added = one @ added @ one.T + model.scatter(step)
        phi = one @ phi
    assert phi == pytest.approx(model.transition(0.030), abs=1e-9)
    assert added == pytest.approx(model.scatter(0.030), rel=1e-6, abs=1e-14)
