"""The search's stages, where there is nothing to take."""

from dataclasses import replace

import numpy as np

from diagnosis.search import search
from diagnosis.split import interleaved
from tests.diagnosis.synthetic import fitted, measured


def test_a_loud_sensor_in_which_no_cause_scores_has_nothing_wrong() -> None:
    """Noise of over a unit has a negative log-likelihood, which is below the zero of no refits at all."""
    data = measured(6.0, 8)
    unseen = np.full(data.cycles, np.nan)
    loud = np.random.default_rng(9).normal(0.0, 40.0, data.cycles)
    baseline = fitted(replace(data, acceleration=data.acceleration + loud, position=unseen, velocity=unseen))
    assert baseline.train_nats < -1000.0
    assert not search(baseline, interleaved(6.0), only=["joint_friction"]).findings
