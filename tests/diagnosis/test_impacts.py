"""Blows that no sensor measured are found where they fell, and only where they fell."""

from math import pi

import pytest

from stillarm.diagnosis.fit import fit, make_data
from stillarm.diagnosis.impacts import _merged, _redated, fit_with_impacts, pruned
from stillarm.diagnosis.split import interleaved
from stillarm.diagnosis.world import World
from tests.fixtures.synthetic import MODEL, measured


def impact(number: int, amplitude_m: float) -> dict[str, float]:
    """A blow from which the arm rings on by so much."""
    return {f"jump.{number}.0.v": 2.0 * pi * 2.6 * amplitude_m}


@pytest.mark.parametrize("cycles", [(2800,), (1500, 5200, 8100)])
def test_impacts_are_found_within_some_milliseconds(cycles: tuple[int, ...]) -> None:
    sizes = (0.02, -0.015, 0.012)
    values = {key: value for j in range(len(cycles)) for key, value in impact(j + 1, sizes[j]).items()}
    data = measured(10.0, 3, values, impacts=cycles)
    found = fit_with_impacts(World(data, MODEL), interleaved(10.0))
    assert len(found.world.impacts) == len(cycles)
    for cycle, seen in zip(cycles, found.world.impacts, strict=True):
        assert abs(cycle - seen) <= 8
    assert found.value("modes.0.frequency_hz") == pytest.approx(2.6, rel=1e-3)


def test_where_nothing_struck_nothing_is_found() -> None:
    data = measured(8.0, 4)
    assert fit_with_impacts(World(data, MODEL), interleaved(8.0)).world.impacts == ()


def test_of_two_impacts_that_share_one_where_it_is_held_out_one_stays() -> None:
    split = interleaved(9.0)
    assert split.held[4]
    data = measured(9.0, 3, impact(1, 0.02), impacts=(4300,))
    both = World(data, MODEL, impacts=(4300, 4700))
    last = fit(make_data(both, split), both.space.vector(), both.baseline_names())
    left = pruned(last, split)
    assert len(left.world.impacts) == 1
    assert left.train_log_likelihood > last.train_log_likelihood - 10.0


def test_two_instants_on_either_side_of_an_impact_become_one() -> None:
    data = measured(9.0, 3, impact(1, 0.02), impacts=(5500,))
    split = interleaved(9.0)
    world = World(data, MODEL, impacts=(5360, 5640))
    beside = fit(make_data(world, split), world.space.vector(), world.baseline_names())
    assert _merged(beside, split, ()).world.impacts == (pytest.approx(5500, abs=3),)


def test_two_impacts_within_two_periods_stay_two() -> None:
    cycles = (5360, 5640)
    world = World(measured(9.0, 3, impact(1, 0.02) | impact(2, 0.02), cycles), MODEL, cycles)
    split = interleaved(9.0)
    both = fit(make_data(world, split), world.space.vector(), world.baseline_names())
    assert _merged(both, split, ()).world.impacts == cycles


@pytest.mark.parametrize("late", [1, -1])
def test_an_impact_that_is_found_half_a_period_off_is_dated_again(late: int) -> None:
    split = interleaved(9.0)
    data = measured(9.0, 3, impact(1, 0.02), impacts=(5500,))
    world = World(data, MODEL, impacts=(5500 + late * 192,))
    off = fit(make_data(world, split), world.space.vector(), world.baseline_names())
    assert _redated(off, split, ()).world.impacts == (pytest.approx(5500, abs=3),)


def test_an_impact_that_is_dated_well_stays() -> None:
    split = interleaved(9.0)
    world = World(measured(9.0, 3, impact(1, 0.02), (5500,)), MODEL, (5500,))
    last = fit(make_data(world, split), world.space.vector(), world.baseline_names())
    assert _redated(last, split, ()) is last
