"""An impact where it is held out, in a rig with a mode that fades before the next block."""

from dataclasses import replace
from math import pi

import msgspec
import numpy as np
import pytest

from stillarm.common.files.model import Arm, Mode
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import make_data
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.sensors.accelerometer_faults import _struck, unpredictable
from stillarm.diagnosis.sensors.laws import laws
from tests.fixtures.synthetic import MODEL, measured

STRUCK = 4300
SPLIT = interleaved(9.0)
TWO = msgspec.structs.replace(
    MODEL,
    arm=Arm(length_m=2.0, modes=[Mode(), Mode(frequency_hz=15.0, damping_ratio=0.12, participation=-0.1)]),
)


def test_a_mode_that_an_impact_shook_and_nothing_else_shows_is_no_discovery() -> None:
    impact = {"jump.1.0.v": 2.0 * pi * 2.6 * 0.02, "jump.1.1.v": 0.5}
    data = measured(9.0, 3, impact, impacts=(STRUCK,), model=TWO)
    world = World(data, TWO, impacts=(STRUCK,))
    marked = make_data(world, replace(SPLIT, lends=False))
    last = fit(marked, world.space.vector(), world.baseline_names())
    struck = unpredictable(marked, last)
    assert struck.tolist() == [block == 4 for block in range(9)]
    assert not laws(marked, last)


def test_a_mode_that_the_first_instants_after_an_impact_train_is_predictable() -> None:
    impact = {"jump.1.0.v": 2.0 * pi * 2.6 * 0.02, "jump.1.1.v": 0.5}
    world = World(measured(9.0, 3, impact, impacts=(STRUCK,), model=TWO), TWO, impacts=(STRUCK,))
    marked = make_data(world, SPLIT)
    last = fit(marked, world.space.vector(), world.baseline_names())
    assert not unpredictable(marked, last).any()
    assert last.value("jump.1.1.v") == pytest.approx(0.5, rel=0.1)


def test_an_impact_that_is_followed_is_predictable() -> None:
    data = measured(9.0, 3, {"jump.1.0.v": 2.0 * pi * 2.6 * 0.02}, impacts=(STRUCK,))
    world = World(data, MODEL, impacts=(STRUCK,))
    marked = make_data(world, SPLIT)
    last = fit(marked, world.space.vector(), world.baseline_names())
    assert not unpredictable(marked, last).any()


def test_an_impact_just_before_a_block_leaves_no_time_to_learn_from_it() -> None:
    for struck_s, seen in (
        (3.9, [4]),
        (3.5, []),
        (4.3, [4]),
        (4.9, [4]),
    ):  # of 3 to 5 s, 4 to 5 s is held out
        struck = round(struck_s / 0.001)
        world = World(measured(9.0, 3, model=MODEL), MODEL, impacts=(struck,))
        last = fit(make_data(world, SPLIT), world.space.vector(), (), iterations=0)
        assert _struck(last, SPLIT) == seen


def test_a_block_that_is_a_little_off_is_predictable() -> None:
    """One and a half times the variance is; two and a half times is not."""
    data = measured(9.0, 3, {"jump.1.0.v": 2.0 * pi * 2.6 * 0.02}, impacts=(STRUCK,))
    world = World(data, MODEL, impacts=(STRUCK,))
    marked = make_data(world, SPLIT)
    last = fit(marked, world.space.vector(), world.baseline_names())
    power = np.nanmean((last.residuals["acceleration"][4000:5000] / last.sigma["acceleration"]) ** 2)
    for times, seen in ((1.5, []), (2.5, [4])):
        louder = (times / power) ** 0.5 * last.residuals["acceleration"]
        off = replace(last, residuals=last.residuals | {"acceleration": louder})
        assert np.flatnonzero(unpredictable(marked, off)).tolist() == seen
