"""Which free terms a name is held against."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision.free_terms import best_free
from stillarm.diagnosis.fitting.fitted import Fit
from tests.fixtures.synthetic import fitted, measured

SPLIT = interleaved(20.0)


@pytest.fixture(scope="module")
def arm() -> Fit:
    return fitted(measured(20.0, 3))


@pytest.mark.slow
def test_free_terms_count_where_a_rest_matters_or_where_the_finding_shows(arm: Fit) -> None:
    """A vibration in the acceleration alone, by less than anyone would act on."""
    name = "acceleration"
    ringing = 0.3 * arm.sigma[name] * np.sin(2.0 * np.pi * 22.0 * arm.world.cycle_times)
    channels = {**arm.predicted.channels, name: arm.predicted.channels[name] - ringing}
    rung = replace(
        arm,
        residuals={**arm.residuals, name: arm.residuals[name] + ringing},
        predicted=replace(arm.predicted, channels=channels),
    )
    assert best_free(rung, SPLIT) is None
    found = best_free(rung, SPLIT, (name,))
    assert found is not None and found.gains[name] > 12.0
