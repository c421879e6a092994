"""The filter bank: covariances stay covariances whatever happens, and a filter begun anew keeps what it must."""

from cmath import exp as complex_exp

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.benchmarks.estimators.trial import assumed_model
from stillarm.benchmarks.estimators.world.regimes import REGIMES
from stillarm.common.files.configuration import Fused
from stillarm.controller.estimation.fused import start
from stillarm.controller.estimation.fused.bank import DISTURBED, FILTERS, LAWS, QUIET, FilterBank, Law, Seen
from stillarm.controller.estimation.fused.blocks import Block, Jump
from stillarm.controller.estimation.fused.layout import Layout

LENGTH_M = 2.0
IMAGE_M2 = 6e-5**2
BLOCK_S = 0.016


def bank() -> tuple[FilterBank, Layout]:
    model = assumed_model(REGIMES["freerun drift"], 0.3)
    at = Layout(model, LENGTH_M)
    return FilterBank(at, start.variances(model, Fused(), at, LENGTH_M), start.jitters_s(model)), at


def ringing() -> tuple[FilterBank, Layout]:
    """A bank that knows its phasor to 1 mm, and how far the dates are off to 5 ms."""
    filters, at = bank()
    filters.x[:, 0], filters.x[:, 1] = 0.004, -0.003
    filters.p[:, 0, 0] = filters.p[:, 1, 1] = 0.001**2
    filters.p[:, at.shift, at.shift] = 0.005**2
    return filters, at


def block_after(filters: FilterBank, at: Layout, value_m: float) -> Block:
    """The accelerometer's next block, without any motion of the joint."""
    start_s, middle_s = filters.edge_s, filters.edge_s + 0.5 * BLOCK_S
    turn = complex_exp(1j * float(at.w[0]) * middle_s)
    return Block(start_s, start_s + BLOCK_S, 16, value_m, (turn,), middle_s, 0.0, 1e-6, (0j,))


def look(
    filters: FilterBank, value_m: float, joint_rate: float = 0.0, joint_rate_variance: float = 0.0
) -> Seen:
    """An image of the bank's own instant."""
    times = np.full(FILTERS, filters.edge_s)
    vibration = filters.vibration_at(times, np.zeros((FILTERS, 1), dtype=np.complex128))
    joint = np.full(FILTERS, joint_rate)
    return filters.look(value_m, vibration, np.zeros(FILTERS), joint, joint_rate_variance, IMAGE_M2)


def check_covariances(filters: FilterBank) -> None:
    """Symmetric, and no direction has a negative variance; measured in the states' own first deviations."""
    scale = np.sqrt(filters._first + 1e-12)
    for one, unit in zip(filters.p, scale, strict=True):
        relative = one / unit[:, None] / unit
        assert np.allclose(relative, relative.T, rtol=1e-6, atol=1e-9)
        assert np.linalg.eigvalsh(0.5 * (relative + relative.T)).min() > -1e-8


actions = st.lists(
    st.tuples(
        st.sampled_from(
            ("block", "image", "arrival", "push", "step", "give", "end", "loosen", "place", "late", "anew")
        ),
        st.floats(-0.02, 0.02),
    ),
    min_size=5,
    max_size=60,
)


def act(filters: FilterBank, at: Layout, action: str, size: float) -> None:
    """One thing that may befall a bank, of about that size, m."""
    if action == "block":
        block = block_after(filters, at, size)
        filters.take_block(filters.aim_at_block(block), block.variance, None)
        filters.move_on(block, np.full((FILTERS, at.size), 1e-12))
    elif action == "image":
        seen = look(filters, size)
        filters.take_image(seen, np.maximum(1.0, seen.nis / 12.0), None)
        filters.symmetrise()
    elif action == "arrival":
        filters.advance_dating(
            np.full(FILTERS, 1 / 65.0), start.shift_return(), np.full(FILTERS, 1e-8), 1e-14
        )
        filters.take_arrival(np.full(FILTERS, size), np.full(FILTERS, 4e-5), np.full(FILTERS, 1e-8))
    elif action == "push":
        filters.inflate(Jump.guessed(filters.edge_s, (abs(size),), abs(size)), QUIET)
    elif action == "step":
        filters.inflate(Jump.stepped(filters.edge_s, size), QUIET)
    elif action == "give":
        filters.give_force(size)
    elif action == "end":
        filters.end_force()
        assert not filters.x[:, at.force].any()
        assert not filters.p[:, at.force].any() and not filters.p[:, :, at.force].any()
    elif action == "loosen":
        filters.loosen(DISTURBED)
    elif action == "place":
        filters.place(int(Law.CLOCK), size)
    elif action == "late":
        filters.begin_late(int(Law.STAMPS), size)
    elif action == "anew":
        filters.begin_near(filters.x[0].copy())


@settings(max_examples=40, deadline=None, derandomize=True)
@given(course=actions)
def test_covariances_stay_symmetric_and_positive_semi_definite(course: list[tuple[str, float]]) -> None:
    """Any order of blocks, images, arrivals, changes of the force, and new beginnings."""
    filters, at = ringing()
    for action, size in course:
        act(filters, at, action, size)
        check_covariances(filters)
        assert np.isfinite(filters.x).all()


def test_only_the_quiet_filters_are_told_of_a_force_that_images_show() -> None:
    filters, at = ringing()
    before = filters.p.copy()
    filters.inflate(Jump(0.3, (0.0,), (0.0,), 0.01), QUIET)
    filters.give_force(0.002)
    assert np.all(filters.p[QUIET, at.force, at.force] > 0.01**2)
    assert np.array_equal(filters.p[DISTURBED], before[DISTURBED])
    assert np.allclose(filters.x[QUIET, at.force], 0.002) and not filters.x[DISTURBED, at.force].any()


def test_a_given_force_takes_from_the_images_zero_what_it_gets() -> None:
    """Images show the sum of both: neither it nor its variance changes."""
    filters, at = ringing()
    filters.x[:, at.offset], filters.p[:, at.offset, at.offset] = 0.007, 1e-9
    row = np.zeros(at.size)
    row[at.offset] = row[at.force] = 1.0
    filters.give_force(0.005)
    assert filters.x[QUIET, at.offset] == pytest.approx([0.002] * LAWS)
    assert filters.x[QUIET] @ row == pytest.approx([0.007] * LAWS)
    assert np.vecdot(filters.p[QUIET] @ row, row) == pytest.approx([1e-9] * LAWS, rel=1e-6)


def test_the_end_of_a_force_is_taken_in_as_a_measurement_of_zero() -> None:
    """Against the conditional mean and covariance of a normal law; what is correlated with the force moves with it."""
    filters, at = ringing()
    filters.inflate(Jump(0.1, (0.0,), (0.0,), 0.01), QUIET)
    filters.x[QUIET, at.force] = 0.003
    x, p, f = filters.x[0].copy(), filters.p[0].copy(), at.force
    filters.end_force()
    rest = [i for i in range(at.size) if i != f]
    assert np.allclose(filters.x[0, rest], (x - p[:, f] / p[f, f] * x[f])[rest], atol=1e-15)
    wanted = p - np.outer(p[:, f], p[:, f]) / p[f, f]
    assert np.allclose(filters.p[0][np.ix_(rest, rest)], wanted[np.ix_(rest, rest)], atol=1e-15)
    assert abs(filters.x[0, 0] - x[0]) > 1e-4


def test_filters_that_begin_near_keep_the_vibration_and_the_images_zero_alone() -> None:
    filters, at = ringing()
    x = filters.x[3].copy()
    x[at.offset], x[at.force], x[at.shift], x[at.frequency] = 0.011, 0.02, 0.03, 0.4
    filters.begin_near(x)
    kept = np.zeros(at.size)
    kept[0], kept[1], kept[at.offset] = 0.004, -0.003, 0.011
    assert np.array_equal(filters.x, np.tile(kept, (FILTERS, 1)))
    first = filters._first[0]
    assert filters.p[0, 0, 0] == pytest.approx(0.25 * 0.005**2 + 0.01 * first[0])
    assert filters.p[0, at.shift, at.shift] == first[at.shift]
    assert np.count_nonzero(filters.p[0] - np.diag(np.diag(filters.p[0]))) == 0


def test_a_vibration_that_is_larger_than_the_first_guess_is_not_better_known_for_it() -> None:
    filters, _ = ringing()
    x = filters.x[0].copy()
    x[0] = 10.0
    filters.begin_near(x)
    assert filters.p[0, 0, 0] == filters._first[0, 0]


def test_place_forgets_what_arrivals_told_of_one_filter_alone() -> None:
    filters, at = ringing()
    act(filters, at, "arrival", 0.01)
    x, p = filters.x.copy(), filters.p.copy()
    filters.place(int(Law.CLOCK), 0.042)
    t, late = at.shift, at.late
    assert (filters.x[0, t], filters.x[0, late]) == (0.042, 0.0)
    assert filters.p[0, t, t] == filters.first_variance(0, t)
    assert filters.p[0, t, late] == filters.p[0, late, t] == 0.0
    assert np.array_equal(filters.x[1:], x[1:]) and np.array_equal(filters.p[1:], p[1:])


def test_a_mean_delay_begun_late_explains_the_arrivals_and_leaves_the_shift() -> None:
    filters, at = ringing()
    filters.x[1, at.shift] = 0.004
    filters.begin_late(1, 0.0215)
    assert filters.x[1, at.shift] == 0.004
    assert filters.x[1, at.shift] + filters.x[1, at.late] == pytest.approx(0.0215)
    assert filters.p[1, at.late, at.late] == 0.1**2
    assert filters.p[1, at.late, at.shift] == 0.0


def told_of_the_shift(filters: FilterBank, at: Layout, joint_rate: float, variance: float) -> float:
    """By how much an image moves the shift of the first filter, s."""
    before = float(filters.x[0, at.shift])
    seen = look(filters, 0.01, joint_rate, variance)
    filters.take_image(seen, np.ones(FILTERS), None)
    return abs(float(filters.x[0, at.shift]) - before)


def test_a_rate_within_its_own_noise_tells_no_instant_while_the_shift_is_unknown() -> None:
    """An arm at rest, its joint moved by the encoder's noise alone; a joint that truly moves does tell."""
    for joint_rate, std, told in ((0.05, 0.1, False), (0.05, 0.0005, True)):
        filters, at = bank()
        filters.p[:, 0, 0] = filters.p[:, 1, 1] = 1e-12
        assert (told_of_the_shift(filters, at, joint_rate, std * std) > 0.0) == told


def test_a_shift_that_images_have_told_is_not_given_up_for_a_noisy_rate() -> None:
    filters, at = bank()
    filters.p[:, 0, 0] = filters.p[:, 1, 1] = 1e-12
    filters.p[:, at.shift, at.shift] = 0.2 * filters._first[:, at.shift]
    seen = look(filters, 0.01, 0.05, 0.1**2)
    assert np.all(np.abs(seen.ph[:, at.shift]) > 0.0)


def test_an_unseen_instant_still_counts_in_the_innovations_variance() -> None:
    """Of an image of which nothing else is unknown: its noise, and the rate's square, as known, by the instant's."""
    filters, at = bank()
    filters.p[:] = 0.0
    shift = filters.p[:, at.shift, at.shift] = filters._first[:, at.shift]
    seen = look(filters, 0.0, 0.05, 0.1**2)
    assert not seen.ph.any()
    wanted = IMAGE_M2 + (0.05**2 + 0.1**2) * (shift + filters.jitter)
    assert seen.variance == pytest.approx(wanted, rel=1e-6)
