"""What a refusal says of cycles that were missed. The verdict itself: test_procedure.py."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from stillarm.diagnosis.calibration.calibrate import Calibration
from stillarm.diagnosis.commissioning.verdict import judge
from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.physics.world import World
from tests.fixtures.synthetic import MODEL, measured

MOVING_S, RESTING_S = 1.0, 0.3  # of synthetic's moves


def without_rows(begin_s: float, lasts_s: float) -> Measured:
    data = measured(8.0, 3)
    first = round(begin_s / data.cycle_s)
    missing = slice(first, first + round(lasts_s / data.cycle_s))
    channels = {name: getattr(data, name).copy() for name in ("acceleration", "position", "velocity")}
    for values in channels.values():
        values[missing] = np.nan
    return replace(data, **channels)


@pytest.mark.parametrize(
    ("begin_s", "lasts_s", "told"),
    [(MOVING_S, 0.1, True), (MOVING_S, 0.005, False), (RESTING_S, 0.1, False)],
)
def test_cycles_missed_while_the_joint_moved_are_told(begin_s: float, lasts_s: float, told: bool) -> None:
    data = without_rows(begin_s, lasts_s)
    world = World(data, MODEL)
    fit = SimpleNamespace(world=world, predicted=world.predict(world.space.vector()))
    vague = cast(Calibration, SimpleNamespace(parameters={}, model=MODEL, fit=fit))
    verdict = judge(vague, data)
    assert not verdict.good
    assert ("missed its cycles for 0.1 s" in verdict.text) is told
