"""A misplaced impact goes to where the accelerometer first shows it, and what was made up for it is dropped."""

from math import pi
from types import SimpleNamespace
from typing import cast

import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.events.impact_onsets import _apart, with_impacts_at_onsets
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import Fit, make_data
from stillarm.diagnosis.fitting.gains import gain_of
from stillarm.diagnosis.physics.world import World
from tests.fixtures.synthetic import MODEL, measured

SECONDS, STRUCK = 9.0, 4300
SPLIT = interleaved(SECONDS)


def fitted_with(impacts: tuple[int, ...]) -> Fit:
    """The fit of an arm that was struck at STRUCK, with impacts at these cycles."""
    data = measured(SECONDS, 3, {"jump.1.0.v": 2.0 * pi * 2.6 * 0.05}, impacts=(STRUCK,))
    world = World(data, MODEL, impacts)
    return fit(make_data(world, SPLIT), world.space.vector(), world.baseline_names())


@pytest.mark.slow
@pytest.mark.parametrize(
    "impacts",
    [(STRUCK + 90,), (STRUCK - 45,), (STRUCK + 90, STRUCK + 700), (STRUCK - 185, STRUCK + 185)],
)
def test_it_goes_to_its_onset(impacts: tuple[int, ...]) -> None:
    begun = fitted_with(impacts)
    found = with_impacts_at_onsets(begun, SPLIT)
    assert len(found.world.impacts) == 1
    assert found.world.impacts[0] == pytest.approx(STRUCK, abs=20)
    assert gain_of(found, begun) > 0.0


def test_one_that_is_where_it_was_stays() -> None:
    begun = fitted_with((STRUCK,))
    assert with_impacts_at_onsets(begun, SPLIT) is begun


def test_impacts_are_moved_together_where_they_are_far_from_each_other() -> None:
    """Four periods of a mode of 2 Hz: within them one may have been made up for another."""
    last = SimpleNamespace(
        world=SimpleNamespace(measured=SimpleNamespace(cycle_s=0.001)), value=lambda name: 2.0
    )
    better = [(1000, 1100), (1000, 1200), (2900, 2950), (9000, 9050)]
    assert _apart(better, cast(Fit, last)) == [(1000, 1100), (9000, 9050)]
