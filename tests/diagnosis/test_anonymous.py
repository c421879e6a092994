"""Terms without a name."""

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.anonymous import explained
from diagnosis.fit import make_data
from diagnosis.split import interleaved
from tests.diagnosis.synthetic import fitted, measured

SPLIT = interleaved(9.0)


@pytest.mark.parametrize(("strays_rad", "told"), [(3e-5, False), (1e-3, True)])
def test_a_joint_that_strays_by_less_than_a_simulation_reaches_is_no_discovery(
    strays_rad: float, told: bool
) -> None:
    data = measured(9.0, 3)
    clean = fitted(data, split=SPLIT).predicted.channels["joint_position"]
    time = np.linspace(-0.5, 0.5, len(clean))
    quiet = clean + np.random.default_rng(5).normal(0.0, 1e-4, len(clean)) + strays_rad * time
    last = fitted(replace(data, position=quiet), split=SPLIT)
    terms = explained(make_data(last.world, SPLIT), last)
    assert (terms.channel == "joint_position") is told
