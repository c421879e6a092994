"""A search begins again beside impacts that its first finding bears out; not where they tell nothing."""

import numpy as np
import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision.beginning_again import to_begin_again
from stillarm.diagnosis.fitting.evidence import score
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import Fit, make_data
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.search.candidates import Candidate, Found, Stage
from tests.diagnosis.events.test_impacts import impact
from tests.fixtures.synthetic import MODEL, measured

SPLIT = interleaved(10.0)
LAW = "arm.quadratic_per_m"


def found_beside(baseline: Fit, final: Fit) -> Found:
    """A search that has taken the damping."""
    nats = score(final, SPLIT).gain(score(baseline, SPLIT))
    taken = Candidate(
        "quadratic_damping", final, 0.0, 0.0, {}, free=(LAW,), merit=float(np.sum(nats)), nats=nats
    )
    return Found(baseline, final, [taken], [Stage([], [taken], taken)])


@pytest.mark.slow
@pytest.mark.parametrize("struck", [True, False])
def test_impacts_that_show_beside_a_finding_are_borne_out(struck: bool) -> None:
    own = impact(1, 0.02) if struck else {}
    data = measured(10.0, 3, {**own, LAW: 5.0}, impacts=(4300,) if struck else ())
    world = World(data, MODEL)
    train = make_data(world, SPLIT)
    baseline = fit(train, world.space.vector(), world.baseline_names())
    final = fit(train, world.space.vector(), (*world.baseline_names(), LAW))
    again = to_begin_again(found_beside(baseline, final), SPLIT)
    if not struck:
        assert again is None
        return
    assert again is not None and again.likelier is not None and again.hint is not None
    there = again.likelier.world
    assert [abs(one - 4300) <= 8 for one in there.impacts] == [True]
    assert there.borne_out == set(there.impacts)
    assert LAW not in again.likelier.free and again.hint.taken.cause == "quadratic_damping"
    assert again.hint.struck
