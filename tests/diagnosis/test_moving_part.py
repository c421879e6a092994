"""Friction that holds the arm: what stands ties a fit to its number of swings, what moves does not."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.fit import fit, make_data
from stillarm.diagnosis.moving_part import begun_on_what_moves, moving_part
from stillarm.diagnosis.split import interleaved
from stillarm.diagnosis.world import World
from tests.fixtures.synthetic import MODEL, fitted, measured

FORCE_M_S2 = 0.12
SIZE = "arm.coulomb_m_s2"
HZ = MODEL.arm.modes[0].frequency_hz
SPLIT = interleaved(20.0)
IMPACT, STRUCK = {"jump.1.0.v": 0.3}, 12_500


@pytest.mark.slow
def test_a_fit_begun_on_what_moves_finds_the_friction_from_far_off() -> None:
    data = measured(20.0, 3, {SIZE: FORCE_M_S2, **IMPACT}, impacts=(STRUCK,))
    world = World(data, MODEL, impacts=(STRUCK,))
    marked = make_data(world, SPLIT)
    last = fit(marked, world.space.vector(), world.baseline_names())
    free = (*last.free, SIZE)
    for share in (0.1, 2.0):
        start = last.vector.copy()
        start[world.space.place[SIZE]] = share * FORCE_M_S2
        begun = begun_on_what_moves(marked, start, SIZE, free, last.colour)
        assert begun is not None
        found = fit(marked, begun, free, colour=last.colour)
        assert abs(found.value(SIZE) / FORCE_M_S2 - 1.0) < 0.02


def test_where_the_arm_never_stands_nothing_is_left_out() -> None:
    swinging = fitted(measured(9.0, 3))
    assert moving_part(make_data(swinging.world, interleaved(9.0)), HZ) is None


def test_what_stands_is_left_out() -> None:
    data = measured(9.0, 3)
    image = data.frames.displacement_px.copy()
    still = np.arange(len(image)) > 300
    image[still] = np.random.default_rng(5).normal(0.1, 0.05, int(still.sum()))
    world = World(replace(data, frames=replace(data.frames, displacement_px=image)), MODEL)
    marked = make_data(world, interleaved(9.0))
    part = moving_part(marked, HZ)
    assert part is not None
    assert not part.train["displacement"][330:].any()
    assert part.train["displacement"][:280].sum() > 0.9 * marked.train["displacement"][:280].sum()
    assert part.train["acceleration"] is marked.train["acceleration"]
