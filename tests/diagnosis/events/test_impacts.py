"""Impacts that no sensor measured are found where they fell, and only where they fell."""

from math import pi

import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.events.impacts import (
    _without_jumps,
    fit_with_impacts,
    impacts_while_moving,
    needs_more,
    pruned,
    refit_with,
    with_further_impacts,
    with_impacts_sought,
)
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import carried_over, make_data
from stillarm.diagnosis.physics.computing import limited
from stillarm.diagnosis.physics.world import World
from tests.fixtures.synthetic import MODEL, measured


def impact(number: int, amplitude_m: float) -> dict[str, float]:
    """An impact from which the arm rings on by so much."""
    return {f"jump.{number}.0.v": 2.0 * pi * 2.6 * amplitude_m}


@pytest.mark.slow
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


@pytest.mark.slow
def test_a_search_from_another_start_ends_where_it_needs_more_impacts_and_is_less_likely() -> None:
    """Here from one that is told too many already, beside a fit with the true one."""
    data, split = measured(10.0, 3, impact(1, 0.02), impacts=(2800,)), interleaved(10.0)
    steady = fit_with_impacts(World(data, MODEL), split)
    many = World(data, MODEL, impacts=(1500, 4200, 7000))
    begun = many.space.with_values(many.space.vector(), {"modes.0.frequency_hz": 2.9})
    ended = with_impacts_sought(many, split, begun, hopeless=lambda one: needs_more(one, steady))
    assert needs_more(ended, steady)
    assert not needs_more(steady, ended)
    assert ended.train_log_likelihood < with_impacts_sought(many, split, begun).train_log_likelihood


def test_of_two_impacts_that_share_one_where_it_is_held_out_one_stays() -> None:
    split = interleaved(9.0)
    assert split.held[4]
    data = measured(9.0, 3, impact(1, 0.02), impacts=(4300,))
    both = World(data, MODEL, impacts=(4300, 4700))
    last = fit(make_data(both, split), both.space.vector(), both.baseline_names())
    left = pruned(last, split)
    assert len(left.world.impacts) == 1
    assert left.train_log_likelihood > last.train_log_likelihood - 10.0


def test_dropping_an_impact_is_foretold_to_first_order() -> None:
    split = interleaved(9.0)
    data = measured(9.0, 3, impact(1, 0.02), impacts=(4300,))
    both = World(data, MODEL, impacts=(2700, 4300))
    last = fit(make_data(both, split), both.space.vector(), both.baseline_names())
    foretold, again = _without_jumps(last, [2700]), refit_with(last, split, (4300,))
    assert foretold.value("jump.1.0.v") == foretold.value("jump.1.0.q") == 0.0
    for name in again.free:
        before = name.replace("jump.1.", "jump.2.")
        assert abs(foretold.value(before) - again.value(name)) < 0.3 * again.std[name], name
        assert foretold.std[before] == pytest.approx(again.std[name], rel=0.05), name


def test_of_impacts_close_together_each_keeps_its_own_state() -> None:
    data = measured(9.0, 3, impact(1, 0.02) | impact(2, -0.01), impacts=(4300, 4340))
    both = World(data, MODEL, impacts=(4300, 4340))
    last = fit(make_data(both, interleaved(9.0)), both.space.vector(), both.baseline_names())
    again = carried_over(last, both.changed(extra_modes=1))
    there = both.changed(extra_modes=1).space.place
    for name in ("jump.1.0.v", "jump.2.0.v"):
        assert again[there[name]] == last.value(name)


def test_the_end_of_what_is_not_judged_stays_beside_a_later_impact() -> None:
    """Without it the arm would ring on, from there to the later one, from a state that nobody judged."""
    split = interleaved(9.0)
    data = measured(9.0, 3, impact(1, 0.02), impacts=(4300,))
    both = World(data, MODEL, impacts=(4400, 4600), unjudged_s=((4.2, 4.4),))
    last = fit(make_data(both, split), both.space.vector(), both.baseline_names())
    assert pruned(last, split).world.impacts == (4400,)


def test_an_impact_that_a_better_model_bears_out_is_neither_dropped_nor_doubtful() -> None:
    data, split = measured(9.0, 3), interleaved(9.0)
    moving = int(data.told_to_move.argmax()) + 100
    for borne_out in (frozenset[int](), frozenset({moving})):
        world = World(data, MODEL, impacts=(moving,), borne_out=borne_out)
        last = fit(make_data(world, split), world.space.vector(), world.baseline_names())
        assert impacts_while_moving(last) == ([] if borne_out else [moving])
        assert pruned(last, split).world.impacts == ((moving,) if borne_out else ())


@pytest.mark.slow
@pytest.mark.parametrize("struck", [True, False])
def test_an_impact_that_shows_before_a_move_is_none_of_the_move(struck: bool) -> None:
    """Within a swing of a move it may be either. What is wrong about the move departs after it has begun."""
    plain = measured(9.0, 3)
    there = int(plain.told_to_move.argmax()) - 150
    data = measured(9.0, 3, impact(1, 0.1), impacts=(there,)) if struck else plain
    world = World(data, MODEL, impacts=(there,))
    last = fit(make_data(world, interleaved(9.0)), world.space.vector(), world.baseline_names())
    assert not data.rests_about(there, round(1.0 / (last.value("modes.0.frequency_hz") * data.cycle_s)))
    assert impacts_while_moving(last) == ([] if struck else [there])
    world.forget()
    with limited(0.0, lambda: 1.0):  # no time is left to tell
        assert impacts_while_moving(last) == [there]


@pytest.mark.slow
def test_what_a_fit_frees_beside_the_baseline_stays_free_while_impacts_are_sought() -> None:
    """A stiffness that is a little off would be made up for by impacts."""
    cubic = "arm.cubic_per_m2"
    data = measured(10.0, 3, {**impact(1, 0.02), cubic: 10.0}, impacts=(4300,))
    split = interleaved(10.0)
    world = World(data, MODEL)
    begun = world.space.with_values(world.space.vector(), {cubic: 8.0})
    found = with_impacts_sought(world, split, begun, extra=(cubic,))
    assert cubic in found.free and len(found.world.impacts) == 1
    assert abs(found.world.impacts[0] - 4300) <= 8
    lacking = fit(make_data(world, split), begun, (*world.baseline_names(), cubic))
    beside = with_further_impacts(lacking, split)
    assert beside.value(cubic) == pytest.approx(10.0, rel=0.05)
    assert [abs(one - 4300) <= 8 for one in beside.world.impacts] == [True]
