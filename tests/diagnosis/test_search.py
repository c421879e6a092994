"""The search's stages, and what is left beside a candidate."""

from dataclasses import replace

import numpy as np

from diagnosis.candidate import Candidate
from diagnosis.choice import ALL
from diagnosis.fit import make_data, strayed
from diagnosis.search import _rest_of, _under, search
from diagnosis.split import interleaved
from diagnosis.structure import examine
from tests.diagnosis.synthetic import fitted, measured


def test_a_loud_sensor_in_which_no_cause_scores_has_nothing_wrong() -> None:
    """Noise of over a unit has a negative log-likelihood, which is below the zero of no refits at all."""
    data = measured(6.0, 8)
    unseen = np.full(data.cycles, np.nan)
    loud = np.random.default_rng(9).normal(0.0, 40.0, data.cycles)
    baseline = fitted(replace(data, acceleration=data.acceleration + loud, position=unseen, velocity=unseen))
    assert baseline.train_nats < -1000.0
    assert not search(baseline, interleaved(6.0), only=["joint_friction"]).findings


def test_what_strays_is_not_cleared_by_what_is_fitted_beside_it() -> None:
    """Taken for noise on one side only, it would be all that is left without the candidate, and nothing with it."""
    data, split = measured(12.0, 8), interleaved(12.0)
    random, wander = np.random.default_rng(5), np.zeros(data.cycles)
    stay = np.exp(-1.0 / 1500.0)
    steps = random.normal(0.0, 0.25 * np.sqrt(1.0 - stay**2), data.cycles)
    for cycle in range(1, data.cycles):
        wander[cycle] = stay * wander[cycle - 1] + steps[cycle]
    last = fitted(replace(data, acceleration=data.acceleration + wander))
    made = make_data(last.world, split)
    strays = _under(made, last, strayed(made, last))
    assert strays is not None
    assert not examine(made, last).channels["acceleration"].white
    assert all(one.white for one in examine(made, strays).channels.values())
    gains = np.ones(len(split.held))
    one = Candidate("lens_distortion", strays, 30.0, 10.0, 1.0, gains, {})
    assert _rest_of(strays, frozenset(), split)(one) == ALL
