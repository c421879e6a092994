"""The bound against the paper notes' closed form, against brute force, and against common sense."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.benchmarks.estimators.bound import bound
from stillarm.benchmarks.estimators.world.generator import Data, generate
from stillarm.benchmarks.estimators.world.regimes import CYCLE_S, REGIMES, Arm, Regime

UNDAMPED = Arm(damping_ratio=1e-6, impact_every_s=(1e3, 2e3), impact_to=(1.0, 1.0))
UNTOLD = replace(
    REGIMES["freerun constant"], name="one delay", skew_ppm=0.0, delay_prior_s=10.0, started_white_s=10.0
)  # nothing but accelerometer and image says when frames were exposed


def closed_form_s(data: Data, images: int, cycles: int) -> float:
    """paper-notes: var(tau) >= (1/w^2) (2 s_a^2 / N_a + 2 s_v^2 / N_v)."""
    arm = data.arm
    return float(
        np.sqrt(2 * data.noise**2 / cycles + 2 * arm.vision_noise**2 / images) / arm.angular_frequency
    )


@pytest.mark.parametrize(("window_s", "noise"), [(1.0, 0.3), (2.0, 0.3), (2.0, 1.0), (4.0, 0.1)])
def test_one_constant_delay_over_a_window_has_the_closed_form(window_s: float, noise: float) -> None:
    """The unknown zero of the image, which the closed form leaves out, costs next to nothing over several periods."""
    data = generate(UNTOLD, noise, (1,), window_s + 0.001, UNDAMPED)
    found = bound(data).delay_std_s[-1]
    cycles, images = int(data.frames.read_cycle[-1]), len(data.frames.number)
    assert found == pytest.approx(closed_form_s(data, images, cycles), rel=0.04)


def test_the_paper_notes_own_figures() -> None:
    """0.83 ms for one second and 0.59 ms for two, at noise 0.3."""
    for window_s, std_s in ((1.0, 0.83e-3), (2.0, 0.59e-3)):
        data = generate(UNTOLD, 0.3, (2,), window_s + 0.001, UNDAMPED)
        assert bound(data).delay_std_s[-1] == pytest.approx(std_s, rel=0.06)


def test_brute_force_maximum_likelihood_attains_it() -> None:
    """Every delay of a grid is tried on 400 noisy trials; for each, amplitudes and zero by least squares."""
    data = generate(UNTOLD, 0.3, (3,), 1.001, UNDAMPED)
    arm, w, random = data.arm, data.arm.angular_frequency, np.random.default_rng(4)
    cycles, trials = int(data.frames.read_cycle[-1]), 400
    time = np.arange(cycles) * CYCLE_S
    true = (
        data.motion.at(time)[2] / (w**2 * arm.amplitude_m),
        data.motion.at(data.frames.exposed_s)[0] / arm.amplitude_m,
    )
    weights = np.concatenate([np.full(cycles, 1 / data.noise), np.full(len(true[1]), 1 / arm.vision_noise)])
    measured = np.concatenate(true)[:, None] * weights[:, None] + random.standard_normal(
        (len(weights), trials)
    )
    limit = bound(data).delay_std_s[-1]
    tried = np.linspace(-5.0, 5.0, 201) * limit
    costs = []
    for error in tried:
        exposed = data.frames.exposed_s + error
        columns = np.zeros((len(weights), 3))
        columns[:cycles, 0], columns[:cycles, 1] = -np.cos(w * time), -np.sin(w * time)
        columns[cycles:, 0], columns[cycles:, 1] = np.cos(w * exposed), np.sin(w * exposed)
        columns[cycles:, 2] = 1.0
        q, _ = np.linalg.qr(columns * weights[:, None])
        costs.append(-np.sum((q.T @ measured) ** 2, axis=0))  # less the power of the data, the same for all
    most_likely = tried[np.argmin(np.array(costs), axis=0)]
    assert np.sqrt(np.mean(most_likely**2)) == pytest.approx(limit, rel=0.1)
    assert abs(np.mean(most_likely)) < 0.2 * limit


def test_with_jitter_the_exact_posterior_mean_attains_it() -> None:
    """The accelerometer is nearly perfect, exposures and n_i are unknown: each delay by integrating its exact
    posterior.
    """
    drawn = replace(REGIMES["triggered jitter"], jitter_s=0.003)
    told = replace(drawn, trigger_walk_s=5.0, started_white_s=10.0, delay_prior_s=1e-9)
    squares, limits = [], []
    for trial in range(4):
        data = generate(drawn, 0.002, (trial,), 8.0, UNDAMPED)
        limits.append(bound(replace(data, regime=told)).delay_std_s[20:] ** 2)
        grid = np.linspace(-0.016, 0.016, 321)
        assumed = data.frames.read_cycle[:, None] * CYCLE_S - (0.074 + grid)[None, :]
        zero = np.mean(data.seen_m - data.motion.at(data.frames.exposed_s)[0])
        misfit = data.seen_m[:, None] - zero - data.motion.at(assumed.ravel())[0].reshape(assumed.shape)
        variance = drawn.jitter_s**2 + CYCLE_S**2 / 12
        log = -0.5 * (misfit / (0.01 * data.arm.amplitude_m)) ** 2 - 0.5 * (grid**2 / variance)[None, :]
        weight = np.exp(log - log.max(axis=1, keepdims=True))
        mean = 0.074 + (weight @ grid) / weight.sum(axis=1)
        squares.append((mean - data.frames.delay_s)[20:] ** 2)
    attained = np.sqrt(np.mean(np.concatenate(squares)))
    assert attained == pytest.approx(np.sqrt(np.mean(np.concatenate(limits))), rel=0.08)


@pytest.mark.parametrize("name", list(REGIMES))
def test_it_is_finite_positive_and_falls_with_every_improvement(name: str) -> None:
    """A quieter accelerometer, a better clock, a steadier delay: none may raise it, in any regime."""
    regime = REGIMES[name]
    data = generate(regime, 0.3, (1,), 8.0, Arm())
    usual = bound(data)
    assert np.all(np.isfinite(usual.delay_std_s))
    assert np.all(usual.delay_std_s > 0.0)
    assert np.all(usual.deflection_std_m > 0.0)

    def is_below(regime: Regime, noise: float) -> None:
        better = bound(replace(data, regime=regime, noise=noise))
        assert np.all(better.delay_std_s <= usual.delay_std_s * (1.0 + 1e-6))
        assert np.all(better.deflection_std_m <= usual.deflection_std_m * (1.0 + 1e-6))

    is_below(regime, 0.1)
    is_below(replace(regime, started_white_s=0.001), 0.3)
    is_below(replace(regime, stamped=True), 0.3)
    is_below(replace(regime, jitter_s=0.5 * regime.jitter_s, drift_s=0.5 * regime.drift_s), 0.3)


def test_what_was_learnt_of_the_clock_outlives_an_impact() -> None:
    """An impact raises the deflection's bound at once; in freerun the delay's bound never rises."""
    data = generate(REGIMES["freerun drift"], 0.3, (1,), 12.0, Arm())
    limit = bound(data)
    impact = data.motion.impacts_s[1]
    read = data.frames.read_cycle * CYCLE_S
    before, after = np.searchsorted(read, impact) - 1, np.searchsorted(read, impact + 0.02)
    assert limit.deflection_std_m[after] > 1.2 * limit.deflection_std_m[before]
    assert np.all(np.diff(limit.delay_std_s[20:]) < 1e-6)


def test_lost_frames_cost_only_what_they_would_have_told() -> None:
    """With a tenth of the frames gone the clock runs on; the bound rises a little."""
    data = generate(REGIMES["freerun drift"], 0.3, (1,), 8.0, Arm())
    lost = np.random.default_rng(0).uniform(size=len(data.frames.number)) < 0.1
    lost[0] = False
    whole, holed = bound(data).delay_std_s[~lost], bound(data.with_frames_lost(lost)).delay_std_s
    assert np.all(holed >= whole * (1.0 - 1e-6))
    assert holed[-1] < 1.3 * whole[-1]


@pytest.mark.parametrize("noise", [0.1, 0.3])
def test_nothing_tells_an_impacts_instant_within_its_cycle(noise: float) -> None:
    """Its samples moved on by 0.9 ms, behind the first one it touched, are the same; by 1.1 ms they are not.

    Hence the instant's variance of a cycle squared over twelve; its size they show to the noise of their sum.
    """
    data = generate(REGIMES["freerun constant"], noise, (5,), 6.0, Arm())
    start = np.floor(data.motion.impacts_s[0] / CYCLE_S) * CYCLE_S
    time = start + CYCLE_S * np.arange(-20, 20)

    def shown(begun_s: float) -> np.ndarray:
        return np.asarray((time > begun_s) & (time <= begun_s + data.arm.impact_s), dtype=float)

    assert np.array_equal(shown(start + 0.00005), shown(start + 0.00095))
    assert not np.array_equal(shown(start + 0.00005), shown(start + 0.00115))
    assert shown(start + 0.0005).sum() == 6


def test_behind_an_impact_the_deflection_is_as_uncertain_as_the_impacts_own_samples_leave_it() -> None:
    """A quarter period behind it, where its velocity has become deflection: beside what was uncertain before."""
    data = generate(REGIMES["freerun drift"], 0.3, (1,), 12.0, Arm())
    limit, arm = bound(data).deflection_std_m, data.arm
    read = data.frames.read_cycle * CYCLE_S
    for impact in data.motion.impacts_s:
        before, behind = np.searchsorted(read, impact) - 1, np.searchsorted(read, impact + 0.09)
        size = 0.3 * arm.angular_frequency**2 * arm.amplitude_m * np.sqrt(6.0) * CYCLE_S
        assert limit[behind] < 1.3 * np.hypot(limit[before], size / arm.angular_frequency)
        assert limit[behind] > 0.5 * size / arm.angular_frequency
