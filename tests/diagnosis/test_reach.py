"""A threshold is known as well as the data tell two values of it apart: hardly, where nothing lies between."""

import pytest

from stillarm.diagnosis.catalogue import CAUSES
from stillarm.diagnosis.fit import fit, make_data
from stillarm.diagnosis.reach import reach_of
from stillarm.diagnosis.split import interleaved
from stillarm.diagnosis.world import World
from tests.fixtures.synthetic import MODEL, measured

SPLIT = interleaved(6.0)
BAND = "drive.deadband_rad_s"


def reach(band: float) -> float:
    """Of a dead band: commands are 0.25, 0.2 and 0.05 rad/s, and a sweep up to 0.05."""
    world = World(measured(6.0, 3, {BAND: band}), MODEL)
    start = world.space.with_values(world.space.vector(), {BAND: band, "jump.0.0.q": 0.02})
    last = fit(make_data(world, SPLIT), start, world.baseline_names())
    return reach_of(last, CAUSES["drive_deadband"], SPLIT)[BAND]


def test_where_no_command_lies_between_any_value_does() -> None:
    assert reach(0.09) == pytest.approx(0.09, rel=0.02)  # up to 0.18, as far as it is looked


def test_where_a_command_sweeps_across_the_band_its_edge_is_known() -> None:
    assert reach(0.03) < 0.002
