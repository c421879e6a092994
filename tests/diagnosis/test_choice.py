"""The choice among refitted causes, on candidates made by hand."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.candidate import Candidate, Found, Stage
from stillarm.diagnosis.catalogue import CAUSES
from stillarm.diagnosis.cause import Trial
from stillarm.diagnosis.choice import (
    Rest,
    _likelier,
    by_all_blocks,
    choose,
    confidence,
    in_doubt,
    inseparable,
    next_to_take,
    rank,
    rest,
)
from stillarm.diagnosis.laws import LawFound
from stillarm.diagnosis.screen import Scored, Screening
from tests.fixtures.synthetic import fitted, measured

SCREENING = Screening([], threshold_nats=8.0)
BLOCKS = 10
LAW = LawFound("impulse_noise", {}, 0.0, np.zeros(BLOCKS))
LAST = fitted(measured(6.0, 3))
SCATTER = np.array([9.0, -6.0, 3.0, -5.0, 4.0, -8.0, 7.0, -4.0, 6.0, -6.0])


def candidate(cause: str, train: float, held: float) -> Candidate:
    """One quantity, the held-out gain the same in all blocks; all share one fit."""
    gains = np.full(BLOCKS, held / BLOCKS)
    return Candidate(cause, LAST, train, held, 0.0, gains, {}, free=("drive.bandwidth_hz",))


def scattered(one: Candidate, by: float) -> Candidate:
    """The same, its gain uneven over the blocks."""
    return replace(one, block_gains=one.block_gains + by * SCATTER)


def law(cause: str, train: float, held: float) -> Candidate:
    """A law of noise."""
    return replace(candidate(cause, train, held), law=LAW)


def found(*stages: Stage) -> Found:
    """A search that has come so far."""
    taken = [stage.taken for stage in stages if stage.taken is not None]
    return Found(None, None, taken, list(stages))  # type: ignore[arg-type]


LAG, FRICTION = candidate("drive_lag", 200.0, 100.0), candidate("joint_friction", 150.0, 60.0)


def test_rank_keeps_the_better_start_of_a_cause_and_puts_the_largest_held_out_gain_first() -> None:
    worse = replace(LAG, train_gain=190.0, held_out_gain=120.0)
    assert rank([FRICTION, worse, LAG]) == [LAG, FRICTION]


def test_rank_charges_for_further_quantities_and_for_unlikely_values() -> None:
    assert rank([replace(LAG, prior_penalty=41.0), FRICTION])[0] is FRICTION
    assert rank([replace(LAG, held_out_gain=60.5, free=("one", "two")), FRICTION])[0] is FRICTION


@pytest.mark.parametrize(
    "short",
    [
        replace(LAG, train_gain=7.9),
        replace(LAG, held_out_gain=3.4),
        replace(LAG, held_out_std=101.0),
        replace(LAG, values={"bandwidth_hz": (-1.0, 0.1)}),
    ],
    ids=["by chance", "too small a gain", "in few blocks", "outside the catalogue"],
)
def test_what_falls_short_of_one_condition_is_not_chosen(short: Candidate) -> None:
    assert choose([LAG, FRICTION], SCREENING) is LAG
    assert choose([short, FRICTION], SCREENING) is FRICTION


def test_an_onset_may_lie_where_it_is_held_out() -> None:
    payload = candidate("payload_change", 1.0, 90.0)
    assert choose([payload], SCREENING) is payload
    assert choose([replace(LAG, train_gain=1.0)], SCREENING) is None


def in_blocks(one: Candidate, train: list[float], held: list[float]) -> Candidate:
    """The same, its gains in a few blocks of both parts, a few tenths of a nat to and fro elsewhere."""
    chance = np.resize([0.3, -0.3], BLOCKS)
    trained, judged = chance.copy(), chance.copy()
    trained[: len(train)], judged[-len(held) :] = train, held
    spread = float(np.std(judged, ddof=1) * BLOCKS**0.5)
    return replace(
        one, train_gain=trained.sum(), held_out_gain=judged.sum(), held_out_std=spread, block_gains=judged,
        train_blocks=trained,
    )  # fmt: skip


def test_what_shows_in_few_blocks_may_show_in_one_that_is_held_out() -> None:
    few = in_blocks(LAG, [90.0, 16.0], [-2.0, 15.0])
    assert few.held_out_gain < few.held_out_std
    assert choose([few], SCREENING) is few
    assert choose([in_blocks(LAG, [], [-2.0, 15.0])], SCREENING) is None  # there alone
    assert choose([in_blocks(LAG, [90.0], [3.0])], SCREENING) is None  # and next to nothing there
    assert choose([in_blocks(LAG, [90.0, 16.0], [35.0, -20.0])], SCREENING) is None  # for and against


def test_few_blocks_may_speak_a_little_against_what_others_plainly_show() -> None:
    """A twentieth of the best block, and no more."""
    assert choose([in_blocks(LAG, [90.0, 250.0, 75.0], [-10.0, 130.0])], SCREENING) is not None
    assert choose([in_blocks(LAG, [90.0, 250.0, 75.0], [-20.0, 130.0])], SCREENING) is None


def test_a_limit_may_show_where_nothing_is_held_out() -> None:
    """Of a few hard moves none may lie there; but it has to show in more than one, and nothing may speak against it."""
    none = [0.0] * BLOCKS
    limit = in_blocks(candidate("accelerometer_clipping", 0.0, 0.0), [40.0, 30.0, *none[2:]], none)
    assert choose([limit], SCREENING) is limit
    once = in_blocks(limit, [70.0, *none[1:]], none)
    assert choose([once], SCREENING) is None
    against = in_blocks(limit, [40.0, 30.0, *none[2:]], [*none[1:], -6.0])
    assert choose([against], SCREENING) is None
    no_limit = replace(limit, cause="lens_distortion")
    assert choose([no_limit], SCREENING) is None


def test_what_gains_and_loses_by_turns_is_a_noise_that_is_not_white() -> None:
    """As much in the mean as what gains alike everywhere."""
    turns = np.array([20.0, -21.0, 24.0, 17.0, -12.0, 23.0, 3.0, -9.0, 37.0, 19.0])
    held = np.arange(BLOCKS) % 2 == 0
    for gains, taken in ((turns, False), (np.full(BLOCKS, turns.mean()), True)):
        one = replace(
            LAG, train_gain=gains[~held].sum(), held_out_gain=gains[held].sum(), held_out_std=60.0,
            train_blocks=np.where(held, 0.0, gains), block_gains=np.where(held, gains, 0.0),
        )  # fmt: skip
        assert (choose([one], SCREENING) is not None) is taken


def test_blocks_that_differ_because_some_show_far_more_of_a_cause_do_not_speak_against_it() -> None:
    """A gap in the gears, by the moves that cross it; little is lost where a blow falls."""
    shown = [92.0, 61.0, 124.0, -39.0, 235.0, 236.0, 1492.0, 948.0, 66.0, -89.0]
    for factor, taken in ((1.0, True), (6.0, False)):
        gains = np.array([one if one > 0.0 else factor * one for one in shown])
        held = np.arange(BLOCKS) % 2 == 1
        one = replace(
            LAG, train_gain=gains[~held].sum(), held_out_gain=gains[held].sum(), held_out_std=100.0,
            train_blocks=np.where(held, 0.0, gains), block_gains=np.where(held, gains, 0.0),
        )  # fmt: skip
        assert (choose([one], SCREENING) is not None) is taken


def test_what_changed_for_good_shows_in_more_than_one_place() -> None:
    payload = candidate("payload_change", 0.0, 0.0)
    assert choose([in_blocks(payload, [9.0], [9.0])], SCREENING) is not None
    assert choose([in_blocks(payload, [18.0], [0.9])], SCREENING) is None
    clock = candidate("clock_step", 0.0, 0.0)
    assert choose([in_blocks(clock, [18.0], [0.9])], SCREENING) is not None


def test_a_law_waits_but_not_for_what_explains_far_less() -> None:
    noise = law("impulse_noise", 700.0, 300.0)
    assert choose([noise, LAG], SCREENING) is LAG
    assert choose([noise, FRICTION], SCREENING) is noise


def test_what_the_data_show_by_themselves_comes_first() -> None:
    certain = replace(FRICTION, certain=True, held_out_std=1e3)
    assert choose([LAG, certain], SCREENING) is certain
    not_held_out = replace(certain, held_out_gain=0.5)
    assert choose([not_held_out], SCREENING) is not_held_out
    assert choose([replace(certain, held_out_gain=-9.0)], SCREENING) is None


def test_doubt_where_nothing_convinces_or_another_explains_more_of_what_was_searched() -> None:
    assert in_doubt(None, [LAG])
    assert in_doubt(law("impulse_noise", 700.0, 300.0), [LAG])
    assert in_doubt(FRICTION, [LAG, FRICTION])
    assert not in_doubt(LAG, [LAG, FRICTION])
    assert not in_doubt(replace(FRICTION, certain=True), [LAG, FRICTION])


def test_another_name_for_what_is_found_is_noted_and_not_taken() -> None:
    first = Stage(SCREENING, [LAG, FRICTION], LAG)
    again = replace(FRICTION, train_gain=50.0, held_out_gain=20.0)
    assert next_to_take(Stage(SCREENING, [again], again), found(first)) is None
    assert set(first.other_names) == {"joint_friction"}


def test_a_cause_that_explained_little_alone_is_taken_next() -> None:
    first = Stage(SCREENING, [LAG, replace(FRICTION, train_gain=30.0, held_out_gain=9.0)], LAG)
    assert next_to_take(Stage(SCREENING, [FRICTION], FRICTION), found(first)) is FRICTION
    assert first.other_names == []


def test_what_a_simple_form_leaves_of_the_first_finding_is_not_taken() -> None:
    first = found(Stage(SCREENING, [LAG], replace(LAG, train_gain=2000.0, held_out_gain=1000.0)))
    same_place, elsewhere = candidate("joint_friction", 78.0, 39.0), candidate("lens_distortion", 78.0, 39.0)
    assert next_to_take(Stage(SCREENING, [same_place], same_place), first) is None
    assert next_to_take(Stage(SCREENING, [elsewhere], elsewhere), first) is elsewhere
    less = replace(elsewhere, train_gain=18.0, held_out_gain=9.0)
    assert next_to_take(Stage(SCREENING, [less], less), first) is None
    assert (
        next_to_take(Stage(SCREENING, [less], less), first, lambda one: Rest(nothing=True, share=0.0)) is less
    )


def test_what_is_small_beside_a_later_finding_is_what_that_leaves_too() -> None:
    step, lag = candidate("clock_step", 20.0, 10.0), replace(LAG, train_gain=2000.0, held_out_gain=1000.0)
    both = found(Stage(SCREENING, [step], step), Stage(SCREENING, [lag], lag))
    drift = candidate("tracking_drift", 14.0, 5.0)
    assert next_to_take(Stage(SCREENING, [drift], drift), both) is None
    larger = candidate("tracking_drift", 60.0, 20.0)
    assert next_to_take(Stage(SCREENING, [larger], larger), both) is larger


def test_a_small_one_elsewhere_that_clears_a_channel_and_explains_the_most_is_taken() -> None:
    first = found(Stage(SCREENING, [LAG], replace(LAG, train_gain=20000.0, held_out_gain=10000.0)))
    lens, bias = candidate("lens_distortion", 90.0, 45.0), candidate("accelerometer_bias_drift", 80.0, 40.0)
    friction = candidate("joint_friction", 90.0, 45.0)

    def taken(one: Candidate, others: list[Candidate], share: float) -> Candidate | None:
        return next_to_take(Stage(SCREENING, [one, *others], one), first, lambda each: Rest(False, share))

    assert taken(lens, [bias], 0.1) is lens
    assert taken(bias, [lens], 0.1) is lens  # explains more
    assert taken(lens, [], 0.3) is lens  # far ahead of all others
    assert taken(lens, [bias], 0.3) is None  # explains a part of what is there, as another does
    assert taken(lens, [], 0.4) is None
    assert (
        taken(lens, [replace(bias, held_out_gain=1.0, train_gain=120.0)], 0.3) is lens
    )  # that one is chance
    assert taken(replace(lens, held_out_std=10.0), [bias], 1.0) is not None  # steadily
    assert taken(replace(lens, held_out_std=12.0), [bias], 1.0) is None
    assert taken(friction, [], 0.1) is None  # what a lag's simple form leaves


def test_a_small_one_that_is_more_than_a_finding_can_leave_there_is_taken() -> None:
    """The joint's own sensor shows how much is left of a drive's true form."""
    first = found(Stage(SCREENING, [LAG], replace(LAG, train_gain=20000.0, held_out_gain=10000.0)))
    lens, friction = candidate("lens_distortion", 40.0, 20.0), candidate("joint_friction", 40.0, 20.0)

    def taken(one: Candidate, most: dict[str, float]) -> Candidate | None:
        return next_to_take(Stage(SCREENING, [one], one), first, left_elsewhere=lambda: most)

    assert taken(lens, {"drive_lag": 59.0}) is lens
    assert taken(lens, {"drive_lag": 61.0}) is None
    assert taken(lens, {}) is None  # nothing tells
    assert taken(friction, {"drive_lag": 59.0}) is None


def test_blocks_speak_for_a_cause_if_several_do_and_next_to_none_against_it() -> None:
    assert by_all_blocks(np.array([80.0, -4.0, 5.0, 80.0]))  # what grows towards both ends
    assert not by_all_blocks(np.array([80.0, -4.0, 5.0, 0.0]))  # at one place
    assert not by_all_blocks(np.array([80.0, -30.0, 5.0, 80.0]))


@pytest.mark.parametrize(("before", "taken"), [(110.0, True), (1000.0, False), (0.0, False)])
def test_a_small_one_that_promised_as_much_before_anything_was_found_is_taken(
    before: float, taken: bool
) -> None:
    """A likeness of what a simple form leaves would have taken far more of the whole."""

    def screening(nats: float) -> Screening:
        world, start = LAST.world, LAST.vector
        scored = Scored(CAUSES["gravity_leakage"], Trial({}, ()), nats, np.empty(0), world, start)
        return Screening([scored], threshold_nats=8.0)

    first = found(
        Stage(screening(before), [LAG], replace(LAG, train_gain=20000.0, held_out_gain=10000.0)),
    )
    gravity = candidate("gravity_leakage", 100.0, 40.0)
    assert (next_to_take(Stage(screening(100.0), [gravity], gravity), first) is gravity) is taken


def test_the_rest_is_that_of_a_channel_from_which_the_gain_could_come() -> None:
    without = {"acceleration": 200.0, "displacement": 30.0}
    assert rest(150.0, without, {"acceleration": 20.0, "displacement": 30.0}) == Rest(False, 0.1)
    assert rest(150.0, without, {"acceleration": 190.0}) == Rest(False, 1.0)  # the other says too little
    assert rest(150.0, without, {}) == Rest(True, 0.0)
    assert not rest(150.0, {}, {}).nothing


def test_how_much_a_simple_form_leaves_is_a_share_of_all_data() -> None:
    """The held-out part of a finding that shows at a few hard moves may hold more of them, or fewer, than a third."""
    first = found(Stage(SCREENING, [LAG], replace(LAG, train_gain=4700.0, held_out_gain=2900.0)))
    steady = candidate("lens_distortion", 95.0, 28.0)
    assert next_to_take(Stage(SCREENING, [steady], steady), first) is steady


def test_confidence_grows_with_the_lead() -> None:
    alone = confidence(Stage(SCREENING, [LAG], LAG))
    ahead = confidence(Stage(SCREENING, [LAG, FRICTION], LAG))
    level = confidence(Stage(SCREENING, [LAG, replace(FRICTION, held_out_gain=100.0)], LAG))
    assert alone == pytest.approx(0.99) and ahead == pytest.approx(0.99)
    assert level == pytest.approx(0.5)
    assert confidence(Stage(SCREENING, [LAG], None)) == 0.0


def test_inseparable_is_what_predicts_as_well() -> None:
    as_good = candidate("joint_friction", 198.0, 99.0)
    assert inseparable(Stage(SCREENING, [LAG, as_good], LAG)) == ["joint_friction"]
    assert inseparable(Stage(SCREENING, [LAG, FRICTION], LAG)) == []
    noted = Stage(SCREENING, [LAG, FRICTION], LAG, other_names=["joint_friction"])
    assert inseparable(noted) == ["joint_friction"]


@pytest.mark.parametrize(
    ("scatter", "taken"),
    [
        (10.0, "drive_dead_time"),
        (0.1, "drive_lag"),
    ],  # a lead of 120 within, and far beyond, its standard error
)
def test_all_data_tell_two_causes_apart_where_the_held_out_part_does_not(scatter: float, taken: str) -> None:
    lag = scattered(candidate("drive_lag", 620.0, 470.0), scatter)
    dead = candidate("drive_dead_time", 800.0, 350.0)
    assert _likelier(lag, [lag, dead]).cause == taken


def test_a_small_share_of_the_held_out_gain_is_no_reason_against_all_data() -> None:
    lag, dead = candidate("drive_lag", 620.0, 470.0), candidate("drive_dead_time", 720.0, 430.0)
    assert choose([lag, dead], SCREENING) is dead


def test_confidence_is_that_of_all_data_where_they_decided() -> None:
    lag = scattered(candidate("drive_lag", 620.0, 470.0), 3.0)
    dead = candidate("drive_dead_time", 800.0, 430.0)
    assert confidence(Stage(SCREENING, [lag, dead], dead)) > 0.7


def test_an_event_that_needs_no_second_one_is_believed_although_it_lies_in_one_block() -> None:
    gains = np.zeros(BLOCKS)
    gains[3] = 60.0
    one = replace(law("impulse_noise", 60.0, 59.0), held_out_std=60.0, block_gains=gains)
    assert choose([one], SCREENING) is None
    alone = replace(one, law=replace(LAW, alone=True))
    assert choose([alone], SCREENING) is alone


def test_beside_what_the_data_show_by_themselves_a_larger_cause_is_no_rival() -> None:
    certain = replace(FRICTION, certain=True, held_out_gain=40.0)
    stage = Stage(SCREENING, [LAG, certain], certain)
    assert inseparable(stage) == []
    assert confidence(stage) == confidence(Stage(SCREENING, [certain], certain))
    assert inseparable(Stage(SCREENING, [LAG, certain], replace(certain, certain=False))) == ["drive_lag"]
