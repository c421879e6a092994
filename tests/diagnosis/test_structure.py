"""Verdict on what is left of the channels."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from stillarm.diagnosis.fit import make_data
from stillarm.diagnosis.split import interleaved
from stillarm.diagnosis.structure import examine
from tests.fixtures.synthetic import MODEL, fitted, measured

pytestmark = pytest.mark.slow

SPLIT = interleaved(20.0)


def test_arrivals_that_scatter_unevenly_within_the_stated_spread_are_normal() -> None:
    data = measured(20.0, 3)
    frames = data.frames
    busy = (np.arange(len(frames.received_s)) // 40) % 3 == 0
    late = np.random.default_rng(5).normal(0.0, 0.004, len(busy)) * busy
    uneven = replace(data, frames=replace(frames, received_s=np.sort(frames.received_s + late)))
    for stated_s, normal in ((0.0064, True), (0.003, False)):
        timing = msgspec.structs.replace(MODEL.timing, capture_delay_std_s=stated_s)
        last = fitted(uneven, model=msgspec.structs.replace(MODEL, timing=timing), split=SPLIT)
        assert examine(make_data(last.world, SPLIT), last).channels["arrival"].white is normal


def test_arrivals_of_which_each_follows_the_one_before_it_are_normal_within_the_stated_spread() -> None:
    """Every second frame comes later than the others: not what a slow wander does."""
    data = measured(20.0, 4)
    frames = data.frames
    late = 0.004 * (np.arange(len(frames.received_s)) % 2)
    paired = replace(data, frames=replace(frames, received_s=frames.received_s + late))
    for stated_s, normal in ((0.0064, True), (0.002, False)):
        timing = msgspec.structs.replace(MODEL.timing, capture_delay_std_s=stated_s)
        last = fitted(paired, model=msgspec.structs.replace(MODEL, timing=timing), split=SPLIT)
        assert examine(make_data(last.world, SPLIT), last).channels["arrival"].white is normal
