"""A pull at the arm and its release, or a push: found where one was put in, and none where the arm rings freely."""

from dataclasses import replace
from math import pi

import msgspec
import numpy as np
import pytest

from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.data.split import Split, interleaved
from stillarm.diagnosis.events.pulls import _is_a_move, pull_spans_s, push_spans_s, without_pushes
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import Fit, make_data
from stillarm.diagnosis.physics.world import World
from tests.fixtures.synthetic import MODEL, NOISE, measured

SECONDS, RELEASED = 9.0, 5300
RELEASED_S, HELD_S = 5.3, 1.2
SPLIT: Split = interleaved(SECONDS)


JUMP = {"jump.1.0.v": 2.0 * pi * 2.6 * 0.02}


@pytest.fixture(scope="module")
def data() -> Measured:
    """An arm that an impact sets ringing at RELEASED."""
    return measured(SECONDS, 3, JUMP, impacts=(RELEASED,))


def told(data: Measured, more_px: np.ndarray | float = 0.0, impacts: tuple[int, ...] = (RELEASED,)) -> Fit:
    """The true world's fit of the images with more in them."""
    frames = replace(data.frames, displacement_px=data.frames.displacement_px + more_px)
    world = World(replace(data, frames=frames), MODEL, impacts)
    start = World(measured(SECONDS, 3, JUMP, impacts=(RELEASED,)), MODEL, impacts)
    vector = fit(make_data(start, SPLIT), world.space.vector(), start.baseline_names()).vector
    return fit(make_data(world, SPLIT), vector, (), iterations=0)


def seen_s(data: Measured) -> np.ndarray:
    """When each image was exposed."""
    world = World(data, MODEL)
    return np.asarray(world.instants(world.space.vector()))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_pull_is_found_up_to_its_release(data: Measured, side: float) -> None:
    time = seen_s(data)
    held = (time > RELEASED_S - HELD_S) & (time < RELEASED_S)
    rising = 4.0 * np.clip((time - RELEASED_S + HELD_S) / 0.3, 0.0, 1.0)
    spans = pull_spans_s(told(data, side * np.where(held, rising, 0.0)))
    assert len(spans) == 1
    assert spans[0][1] == pytest.approx(RELEASED_S)
    # it is looked for over 0.2 s, and begins up to 0.3 s before it shows
    assert RELEASED_S - HELD_S - 0.5 < spans[0][0] < RELEASED_S - HELD_S + 0.1


def test_a_pull_is_found_while_the_images_stray(data: Measured) -> None:
    """By several times what the pull bends the arm."""
    time = seen_s(data)
    held = np.where((time > RELEASED_S - HELD_S) & (time < RELEASED_S), 1.0, 0.0)
    spans = pull_spans_s(told(data, held + 0.8 * time))
    assert len(spans) == 1
    assert spans[0][1] == pytest.approx(RELEASED_S)
    assert RELEASED_S - HELD_S - 0.5 < spans[0][0] < RELEASED_S - HELD_S + 0.1


def test_images_that_stray_hold_no_pull_by_themselves(data: Measured) -> None:
    assert pull_spans_s(told(data, 0.8 * seen_s(data))) == ()


def test_a_free_ring_down_is_no_pull(data: Measured) -> None:
    assert pull_spans_s(told(data)) == ()


def test_a_swing_that_no_model_tells_is_no_pull(data: Measured) -> None:
    """It goes to both sides."""
    time = seen_s(data)
    before = (time > RELEASED_S - HELD_S) & (time < RELEASED_S)
    swings = np.where(before, 4.0 * np.sin(2.0 * pi * 2.6 * (time - RELEASED_S)), 0.0)
    assert pull_spans_s(told(data, swings)) == ()


def test_what_bends_to_one_side_and_is_not_released_is_no_pull(data: Measured) -> None:
    time = seen_s(data)
    assert pull_spans_s(told(data, np.where((time > 1.5) & (time < 2.7), 4.0, 0.0))) == ()


def test_what_has_ended_before_the_impact_is_no_pull(data: Measured) -> None:
    time = seen_s(data)
    over = (time > RELEASED_S - 2.0) & (time < RELEASED_S - 0.8)
    assert pull_spans_s(told(data, np.where(over, 4.0, 0.0))) == ()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("span", "a_move"), [((0.6, 1.5), True), ((0.6, 3.6), False), ((3.0, 6.0), False), ((5.1, 5.9), False)]
)
def test_what_begins_and_ends_as_the_joint_moves_is_no_pull(
    data: Measured, span: tuple[float, float], a_move: bool
) -> None:
    """Moves from 0.8 to 1.4 s, 1.6 to 2.3, 2.5 to 3.0, 3.2 to 3.9, 4.4 to 4.9."""
    assert _is_a_move(span, told(data)) == a_move


def test_most_of_a_recording_is_no_pull(data: Measured) -> None:
    time = seen_s(data)
    assert pull_spans_s(told(data, np.where((time > 1.0) & (time < RELEASED_S), 4.0, 0.0))) == ()


def test_without_images_nothing_is_found(data: Measured) -> None:
    unseen = replace(data.frames, displacement_px=np.full(len(data.frames.displacement_px), np.nan))
    world = World(replace(data, frames=unseen), MODEL, (RELEASED,))
    assert pull_spans_s(fit(make_data(world, SPLIT), world.space.vector(), (), iterations=0)) == ()


PUSHED_S = 0.24


def pushed(data: Measured, px: float, m_s2: float, since_s: float, until_s: float) -> Fit:
    """What images and accelerometer show between two instants is no model's."""
    inside = (data_cycles(data) >= since_s) & (data_cycles(data) < until_s)
    shaken = replace(data, acceleration=data.acceleration + np.where(inside, m_s2, 0.0))
    time = seen_s(data)
    return told(shaken, np.where((time >= since_s) & (time < until_s), px, 0.0))


def data_cycles(data: Measured) -> np.ndarray:
    return np.arange(data.cycles) * data.cycle_s


@pytest.mark.parametrize(("px", "m_s2"), [(4.0, 0.0), (0.0, 6.0), (-4.0, 6.0)])
def test_a_push_is_found_where_either_sensor_shows_it(data: Measured, px: float, m_s2: float) -> None:
    since, until = RELEASED_S - 0.5 * PUSHED_S, RELEASED_S + 0.5 * PUSHED_S
    spans = push_spans_s(pushed(data, px, m_s2, since, until))
    assert len(spans) == 1
    assert spans[0][0] == pytest.approx(since, abs=0.06)
    assert spans[0][1] == pytest.approx(until, abs=0.06)


def test_a_push_of_a_swing_and_a_half_is_found_where_the_arm_swings_quickly() -> None:
    """Over as long as a departure is looked for, such an arm goes through a fifth of a swing."""
    hz = 9.0
    modes = [msgspec.structs.replace(MODEL.arm.modes[0], frequency_hz=hz)]
    model = msgspec.structs.replace(MODEL, arm=msgspec.structs.replace(MODEL.arm, modes=modes))
    jump = {"jump.1.0.v": 2.0 * pi * hz * 0.02}
    shaken = measured(SECONDS, 3, jump, impacts=(RELEASED,), model=model)
    since, until = RELEASED_S - 1.4 / hz, RELEASED_S + 0.01
    inside = (data_cycles(shaken) >= since) & (data_cycles(shaken) < until)
    shaken = replace(shaken, acceleration=shaken.acceleration + np.where(inside, 20.0, 0.0))
    world = World(shaken, model, (RELEASED,))
    vector = world.space.with_values(world.space.vector(), {**jump, "jump.0.0.q": 0.02})
    spans = push_spans_s(fit(make_data(world, SPLIT), vector, (), iterations=0))
    assert len(spans) == 1
    assert spans[0][0] == pytest.approx(since, abs=0.04) and spans[0][1] == pytest.approx(until, abs=0.05)


def test_a_push_that_goes_on_behind_what_is_not_judged_is_found(data: Measured) -> None:
    """However long that is: the end of a pull was seen too early."""
    since, until = RELEASED_S - 1.25, RELEASED_S + 0.25
    shaken = pushed(data, 4.0, 0.0, since, until)
    world = shaken.world.changed(unjudged_s=((RELEASED_S - 1.2, RELEASED_S),))
    assert push_spans_s(shaken) == ()
    ((_, end),) = push_spans_s(fit(make_data(world, SPLIT), shaken.vector, (), iterations=0))
    assert end == pytest.approx(until, abs=0.06)


def test_a_push_is_not_judged_and_the_arm_rings_on_from_it(data: Measured) -> None:
    found = without_pushes(
        pushed(data, 4.0, 6.0, RELEASED_S - 0.5 * PUSHED_S, RELEASED_S + 0.5 * PUSHED_S), SPLIT
    )
    assert found.world.impacts == (RELEASED,)
    ((since, until),) = found.world.unjudged_s
    shown = found.world.channels["acceleration"]
    assert np.isnan(shown[round(since / data.cycle_s) : round(until / data.cycle_s)]).all()
    off = found.residuals["acceleration"]
    assert np.nanstd(off) == pytest.approx(NOISE["acceleration"], rel=0.05)


def test_an_impact_that_the_model_tells_is_no_push(data: Measured) -> None:
    assert push_spans_s(told(data)) == ()


def test_what_goes_on_after_the_impact_is_no_push(data: Measured) -> None:
    """A cause that acts while the arm swings far departs from the model for as long."""
    assert push_spans_s(pushed(data, 0.0, 6.0, RELEASED_S, RELEASED_S + 1.5)) == ()


def test_what_comes_back_with_each_swing_is_no_push(data: Measured) -> None:
    """A sensor at its limit."""
    time = data_cycles(data)
    tops = (time > RELEASED_S) & (np.sin(2.0 * pi * 2.6 * (time - RELEASED_S)) > 0.8)
    shaken = replace(data, acceleration=data.acceleration + np.where(tops, 6.0, 0.0))
    assert push_spans_s(told(shaken)) == ()


def test_a_push_is_left_out_where_images_alone_show_it() -> None:
    """The arm rings on for long as no impact has it: the impact that accounts for push and ring best fits neither."""
    shaken = measured(SECONDS, 3, JUMP, impacts=(RELEASED,))
    unfelt = replace(shaken, acceleration=np.full(shaken.cycles, np.nan))
    time = seen_s(unfelt)
    inside = np.abs(time - RELEASED_S) < 0.5 * PUSHED_S
    frames = replace(
        unfelt.frames, displacement_px=unfelt.frames.displacement_px + np.where(inside, 40.0, 0.0)
    )
    world = World(replace(unfelt, frames=frames), MODEL, (RELEASED,))
    spoilt = fit(make_data(world, SPLIT), world.space.vector(), world.baseline_names())
    found = without_pushes(spoilt, SPLIT)
    ((since, until),) = found.world.unjudged_s
    assert since < RELEASED_S - 0.4 * PUSHED_S and until > RELEASED_S + 0.4 * PUSHED_S
    off = found.residuals["displacement"]
    assert np.nanstd(off) == pytest.approx(NOISE["displacement"], rel=0.15)


@pytest.mark.slow
def test_a_force_that_swings_the_arm_for_some_periods_is_left_out_where_an_impact_ends_it() -> None:
    """Beyond it the images are as foretold, so that nothing is mended there."""
    shaken = measured(30.0, 3, JUMP, impacts=(20000,))
    unfelt = replace(shaken, acceleration=np.full(shaken.cycles, np.nan))
    time = seen_s(unfelt)
    forced = (time > 18.5) & (time < 20.0)
    swung = np.where(forced, 0.6 * np.sin(2.0 * pi * 2.9 * (time - 18.5)), 0.0)
    frames = replace(unfelt.frames, displacement_px=unfelt.frames.displacement_px + swung)
    world, split = World(replace(unfelt, frames=frames), MODEL, (20000,)), interleaved(30.0)
    spoilt = fit(make_data(world, split), world.space.vector(), world.baseline_names())
    found = without_pushes(spoilt, split)
    ((since, until),) = found.world.unjudged_s
    assert 17.5 < since <= 18.6 and 19.9 <= until < 20.5
    assert np.nanstd(found.residuals["displacement"]) == pytest.approx(NOISE["displacement"], rel=0.15)
