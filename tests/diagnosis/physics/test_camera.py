"""The rate of the camera's clock: what sound clocks differ by is the baseline's, what is beyond it a cause's."""

import numpy as np
import pytest

from stillarm.diagnosis.physics.quantities import QUARTZ, SKEW
from stillarm.diagnosis.physics.world import World
from tests.fixtures.synthetic import MODEL, fitted, measured


@pytest.mark.slow
@pytest.mark.parametrize(("true_ppm", "told_ppm"), [(12.0, 12.0), (400.0, 20.0)])
def test_the_baseline_takes_what_sound_clocks_differ_by_and_no_more(true_ppm: float, told_ppm: float) -> None:
    found = fitted(measured(30.0, 2, {SKEW: true_ppm}))
    assert found.value(QUARTZ) == pytest.approx(told_ppm, abs=4.0)


@pytest.mark.slow
def test_a_wrong_clock_has_one_rate() -> None:
    world = World(measured(6.0, 2), MODEL)
    assert QUARTZ in world.baseline_names()
    assert QUARTZ not in world.with_baseline((SKEW,))
    found = fitted(measured(30.0, 2, {SKEW: 400.0}), SKEW)
    assert found.value(SKEW) + found.value(QUARTZ) == pytest.approx(400.0, abs=4.0)


def test_both_turn_the_same_clock() -> None:
    world = World(measured(6.0, 2), MODEL)
    start = world.space.vector()
    late = [
        world.predict(world.space.with_values(start, {name: 15.0})).channels["arrival"]
        for name in (QUARTZ, SKEW)
    ]
    assert late[0] == pytest.approx(late[1], abs=1e-12)
    plain = world.predict(start).channels["arrival"]
    assert np.ptp(late[0] - plain) == pytest.approx(15e-6 * np.ptp(plain), rel=0.01)
