"""Laws of what is left beside its mean."""

from dataclasses import replace

import numpy as np

from diagnosis.fit import make_data
from diagnosis.scatter import ON_ITS_PAST, uneven
from diagnosis.split import interleaved
from tests.diagnosis.synthetic import fitted, measured

SPLIT = interleaved(9.0)
STEP_RAD = 2.0 * np.pi / 2.0**14


def test_rounding_that_stays_while_the_joint_stands_is_no_memory() -> None:
    data = measured(9.0, 3)
    clean = fitted(data, split=SPLIT).predicted.channels["joint_position"]
    quiet = clean + np.random.default_rng(5).normal(0.0, 8e-5, len(clean))
    rounded = replace(data, position=np.round(quiet / STEP_RAD) * STEP_RAD)
    swaying = replace(data, position=quiet + 5e-4 * np.sin(np.arange(len(clean)) * 0.01))
    for changed, remembers in ((rounded, False), (swaying, True)):
        last = fitted(changed, split=SPLIT)
        laws = {(one.channel, one.law) for one in uneven(make_data(last.world, SPLIT), last)}
        assert (("joint_position", ON_ITS_PAST) in laws) is remembers
