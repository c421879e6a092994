"""When the accelerometer first shows an impact."""

from math import pi

import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.events.impact_departure import departs_at
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import make_data
from stillarm.diagnosis.physics.world import World
from tests.fixtures.synthetic import MODEL, measured

STRUCK = 4300


@pytest.mark.slow
@pytest.mark.parametrize("late", [-60, 0, 60])
def test_an_impact_shows_where_it_was_wherever_it_stands(late: int) -> None:
    data = measured(9.0, 3, {"jump.1.0.v": 2.0 * pi * 2.6 * 0.1}, impacts=(STRUCK,))
    world = World(data, MODEL, impacts=(STRUCK + late,))
    last = fit(make_data(world, interleaved(9.0)), world.space.vector(), world.baseline_names())
    onset = departs_at(last, STRUCK + late)
    assert onset is not None and abs(onset - STRUCK) < 30  # a swing is 380


def test_where_nothing_struck_nothing_departs() -> None:
    data = measured(9.0, 3)
    world = World(data, MODEL, impacts=(STRUCK,))
    last = fit(make_data(world, interleaved(9.0)), world.space.vector(), world.baseline_names())
    assert departs_at(last, STRUCK) is None
