"""What is left of an accelerometer's residual where a gear's flanks strike."""

import numpy as np
import pytest

from stillarm.diagnosis.data.noise import fast_noise
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import make_data
from stillarm.diagnosis.physics.accelerometer import without_strikes
from stillarm.diagnosis.physics.quantities import LAG_BEND, MOST_DOWN, MOST_UP, RANGE
from stillarm.diagnosis.physics.world import World
from tests.fixtures.synthetic import MODEL, fitted, measured

GAP = 0.004  # rad
N, STEP_S, NOISE_STD = 1000, 0.001, 0.1
OMEGA = np.where((np.arange(N) >= 300) & (np.arange(N) < 600), 0.2, 0.0)  # it rests, and is struck twice


def test_noise_is_told_beside_the_motion() -> None:
    time = np.arange(20000) * STEP_S
    values = 3.0 * np.sin(2.0 * np.pi * 15.0 * time) + np.random.default_rng(1).normal(0.0, NOISE_STD, 20000)
    values[40:60] = np.nan
    assert fast_noise(values) == pytest.approx(NOISE_STD, rel=0.05)
    assert fast_noise(np.full(100, np.nan)) == 0.0


def test_a_spike_is_cut_to_what_noise_may_be_where_a_strike_can_reach() -> None:
    residual = np.random.default_rng(2).normal(0.0, 0.5 * NOISE_STD, N)
    residual[[302, 450, 603]] = 20.0, 20.0, -500.0
    left = without_strikes(residual, OMEGA, 1.0, NOISE_STD, STEP_S)
    assert left[302] == pytest.approx(3.0 * NOISE_STD)
    assert left[450] == 20.0  # no strike there
    assert left[603] == pytest.approx(-300.0)  # a strike brings 0.2 rad/s within a cycle, and no more
    usual = np.abs(residual) < 3.0 * NOISE_STD
    assert np.array_equal(left[usual], residual[usual])
    still = without_strikes(residual, np.full(N, 0.2), 1.0, NOISE_STD, STEP_S)
    assert np.array_equal(still, residual)


def test_spikes_of_strikes_cost_the_right_play_no_more_than_noise_may() -> None:
    """With Huber's tails a loud fit would lose less by them than a quiet one, and be the likelier."""
    data, split = measured(6.0, 4, {"drive.gap_rad": GAP}), interleaved(6.0)
    plain = fitted(data)
    made = make_data(plain.world, split)
    at_it = plain.world.space.with_values(plain.vector, {"drive.gap_rad": GAP})
    quiet = fit(made, at_it, plain.free, colour=plain.colour)
    omega = quiet.predicted.motion.joint[:, 1]
    struck = np.flatnonzero((omega[1:] != 0.0) & (omega[:-1] == 0.0)) + 1
    data.acceleration[struck] += 0.8 * 2.0 * np.abs(omega[struck]) / data.cycle_s
    spiked = fit(make_data(World(data, MODEL), split), quiet.vector, (), iterations=0, colour=plain.colour)
    off = data.acceleration - spiked.predicted.channels["acceleration"]
    assert float(np.median(off[struck])) > 500.0 * spiked.sigma["acceleration"]
    assert spiked.train_log_likelihood > quiet.train_log_likelihood - 6.0 * len(struck)


def test_a_limit_of_one_side_leaves_the_other_as_it_was() -> None:
    world = World(measured(4.0, 1, {"jump.0.0.q": 0.02}), MODEL)
    free = world.predict(world.space.vector()).channels["acceleration"]
    limit = 0.4 * float(np.max(np.abs(free)))
    for name, seen in (
        (MOST_UP, np.minimum(free, limit)),
        (MOST_DOWN, np.maximum(free, -limit)),
        (RANGE, np.clip(free, -limit, limit)),
    ):
        shown = world.predict(world.space.with_values(world.space.vector(), {name: limit})).channels
        assert np.array_equal(shown["acceleration"], seen) and not np.array_equal(seen, free)


def test_a_filter_of_second_order_is_the_equation_solved_by_small_steps() -> None:
    """1 / (1 + lag s + bend (lag s)^2), by another integrator: a bend of 1/4 is two lags in a row."""
    lag_s, bend = 0.012, 0.25
    hidden = {"accelerometer.lag_s": lag_s, LAG_BEND: bend}
    world = World(measured(3.0, 1), MODEL)
    plain = world.predict(world.space.vector()).channels["acceleration"]
    shown = world.predict(world.space.with_values(world.space.vector(), hidden)).channels["acceleration"]
    steps = 50
    fine = np.interp(np.arange((len(plain) - 1) * steps + 1) / steps, np.arange(len(plain)), plain)
    first = second = fine[0]
    kept = np.empty(len(fine))
    for k, value in enumerate(fine.tolist()):
        first += (value - first) * (STEP_S / steps) / (0.5 * lag_s)
        second += (first - second) * (STEP_S / steps) / (0.5 * lag_s)
        kept[k] = second
    assert np.max(np.abs(shown - kept[::steps])) < 0.01 * np.max(np.abs(plain - shown))


def test_a_hum_stays_where_it_is_while_its_onset_is_sought() -> None:
    """Its phase is of the recording's time: from any onset on it is the same wave."""
    world = World(measured(4.0, 1), MODEL)
    hum = {"accelerometer.hum_hz": 49.97, "accelerometer.hum_sin": 1.0, "accelerometer.hum_cos": -2.0}

    def reads(begin_s: float) -> np.ndarray:
        vector = world.space.with_values(world.space.vector(), hum | {"accelerometer.begin_s": begin_s})
        return world.predict(vector).channels["acceleration"]

    for begin_s in (1.0, 1.007, 2.503):
        acts = world.cycle_times >= begin_s
        assert reads(begin_s)[acts] == pytest.approx(reads(0.0)[acts], abs=1e-9)
