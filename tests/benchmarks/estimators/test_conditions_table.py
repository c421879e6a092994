"""The third table's conditions."""

import numpy as np
import pytest

from stillarm.benchmarks.estimators.conditions_table import (
    CLOSED_LOOP,
    CONDITIONS,
    OPEN_LOOP,
)
from stillarm.benchmarks.estimators.world.generator import generate
from stillarm.benchmarks.estimators.world.regimes import REGIMES, Arm


def test_a_trial_of_old_keeps_its_seed() -> None:
    """New regimes and conditions come last: a place in the table is part of the seed of the trials."""
    assert list(REGIMES)[:9] == [
        f"{a} {b}" for a in ("freerun", "triggered", "stamped") for b in ("constant", "drift", "jitter")
    ]
    assert CONDITIONS[: len(OPEN_LOOP) + len(CLOSED_LOOP)] == (*OPEN_LOOP, *CLOSED_LOOP)
    assert (len(OPEN_LOOP), len(CLOSED_LOOP)) == (9, 2)


def test_conditions_do_to_the_data_what_they_say() -> None:
    """Frames go, the accelerometer dies or sticks, the payload lowers the frequency."""
    data = generate(
        REGIMES["freerun drift"], 0.3, (1,), 24.0, Arm(), OPEN_LOOP["payload at 20 s: frequency -10 %"].change
    )
    random = np.random.default_rng(1)
    lost = OPEN_LOOP["10 % of the frames lost"].change_data(data, random)
    assert len(lost.seen_m) / len(data.seen_m) == pytest.approx(0.9, abs=0.03)
    dead = OPEN_LOOP["accelerometer dead at 20 s"].change_data(data, random).acceleration_m_s2
    stuck = OPEN_LOOP["accelerometer stuck at 20 s"].change_data(data, random).acceleration_m_s2
    assert np.isnan(dead[20000:]).all()
    assert len(set(stuck[20000:].tolist())) == 1
    for changed in (dead, stuck):
        assert np.array_equal(changed[:20000], data.acceleration_m_s2[:20000])
    w = np.abs(data.motion.pole[data.motion.piece_at(np.array([19.9, 20.1]))])
    assert w[1] / w[0] == pytest.approx(0.9)
