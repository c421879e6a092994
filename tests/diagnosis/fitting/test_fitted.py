"""What trains just after an impact in a block that is held out."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.fitting.fitted import make_data
from stillarm.diagnosis.physics.world import World
from tests.fixtures.synthetic import MODEL, empty

SECONDS = 9.0
SPLIT = interleaved(SECONDS)
STRUCK_S = float(SPLIT.edges_s[:-1][SPLIT.held][1]) + 0.1
"""Within a block that is held out."""


def lent_s(data: Measured, channel: str, lends: bool = True) -> tuple[float, float] | None:
    """From when to when a channel trains within held-out blocks, s; None: nowhere."""
    world = World(data, MODEL, (round(STRUCK_S / data.cycle_s),))
    times = world.times_of(channel)
    trains = make_data(world, replace(SPLIT, lends=lends)).train[channel]
    lent = times[trains & SPLIT.held[SPLIT.blocks_of(times)]]
    return (float(lent.min()), float(lent.max())) if len(lent) else None


@pytest.mark.parametrize("lends", [True, False])
def test_the_accelerometer_trains_just_after_an_impact_if_the_split_lends_that(lends: bool) -> None:
    found = lent_s(empty(SECONDS), "acceleration", lends)
    if not lends:
        assert found is None
        return
    assert found is not None
    assert found[0] > STRUCK_S  # its stroke is not judged
    assert found[1] == pytest.approx(STRUCK_S + 0.3, abs=0.01)
    assert lent_s(empty(SECONDS), "displacement") is None


def test_where_there_is_no_accelerometer_images_do() -> None:
    data = replace(empty(SECONDS), acceleration=np.full(empty(SECONDS).cycles, np.nan))
    found = lent_s(data, "displacement")
    assert found is not None
    assert found[0] == pytest.approx(STRUCK_S, abs=0.03)
    assert found[1] == pytest.approx(STRUCK_S + 0.3 + MODEL.timing.capture_delay_s, abs=0.03)
