"""The benchmark's generator: its statistics are as stated, and it shares no code with what it judges."""

import ast
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from stillarm.benchmarks.estimators.world.generator import Change, expose, generate, strike_again
from stillarm.benchmarks.estimators.world.regimes import (
    CYCLE_S,
    FRAME_S,
    REGIMES,
    VARIATION_S,
    Arm,
)

PACKAGE = Path(__file__).parents[4] / "benchmarks" / "estimators"
OWN = {
    "stillarm.benchmarks.estimators.world.busy_computer",
    "stillarm.benchmarks.estimators.world.regimes",
    "stillarm.benchmarks.estimators.world.generator",
    "stillarm.common.user_error",
}


@pytest.mark.parametrize(
    "name",
    ["world/regimes", "world/busy_computer", "world/generator", "world/excitation", "bound"],
)
def test_it_shares_no_code_with_what_it_judges(name: str) -> None:
    """Neither controller/ nor simulation/, nor the model file that both read, not even through another module."""
    tree = ast.parse((PACKAGE / f"{name}.py").read_text())
    named = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module}
    named |= {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    ours = {module for module in named if module.split(".")[0] == "stillarm"}
    assert ours <= OWN


@given(seed=st.integers(0, 10_000), change=st.booleans())
@settings(max_examples=25, deadline=None, derandomize=True, phases=[Phase.explicit, Phase.generate])
def test_the_motion_obeys_the_modes_equation(seed: int, change: bool) -> None:
    """Each piece: q' is the slope of q, q'' that of q', q'' + 2 zeta w q' + w^2 q is the force; no jumps between."""
    arm = Arm(damping_ratio=0.03)
    motion = strike_again(arm, 9.0, np.random.default_rng(seed), Change(4.0, 0.9) if change else None)
    h = 1e-5
    time = np.linspace(0.01, 9.0, 700)
    away = np.min(np.abs(time[:, None] - motion.start_s[None, :]), axis=1) > 3 * h
    q, v, a = motion.at(time[away])
    before, after = motion.at(time[away] - h), motion.at(time[away] + h)
    assert (after[0] - before[0]) / (2 * h) == pytest.approx(v, abs=1e-7)
    assert (after[1] - before[1]) / (2 * h) == pytest.approx(a, abs=1e-4)
    w = arm.angular_frequency * np.where(change & (time[away] > 4.0), 0.9, 1.0)
    force = motion.force_m_s2[motion.piece_at(time[away])]
    assert a + 2 * arm.damping_ratio * w * v + w**2 * q == pytest.approx(force, abs=1e-9)
    for start in motion.start_s[1:]:
        left, right = motion.at(np.array([start - 1e-9])), motion.at(np.array([start + 1e-9]))
        assert left[0] == pytest.approx(right[0], abs=1e-9)
        assert left[1] == pytest.approx(right[1], abs=1e-6)


def test_the_amplitude_stays_within_a_factor_of_two() -> None:
    """At every moment of every trial; the impacts are as large as the bound assumes."""
    arm, time, kicks = Arm(), np.arange(0.0, 40.0, 0.001), []
    for seed in range(40):
        motion = strike_again(arm, 40.0, np.random.default_rng(seed))
        q, v, _ = motion.at(time)
        amplitude = np.hypot(q, v / arm.angular_frequency) / arm.amplitude_m
        assert amplitude.max() < 2.0 * amplitude.min()
        assert amplitude.min() > 0.6
        assert amplitude.max() < 1.3
        gaps = [b - a for a, b in pairwise(motion.impacts_s)]
        assert min(gaps) > 2.3
        kicks += list(motion.impact_velocity_m_s)
    assert np.sqrt(np.mean(np.square(kicks))) == pytest.approx(arm.impact_std_m_s, rel=0.08)


@pytest.mark.parametrize("name", [name for name in REGIMES if name != "live"])
def test_delays_and_exposures_follow_the_stated_law(name: str) -> None:
    """Mean, spread, memory, order; regular exposures in freerun and irregular ones where triggered; n_i; stamps."""
    regime, means, spreads, memories, steps = REGIMES[name], [], [], [], []
    for seed in range(30):
        frames = expose(regime, 40.0, np.random.default_rng(seed))
        delay = frames.delay_s
        assert np.all(np.diff(frames.read_cycle) >= 0)
        assert np.all(np.diff(frames.exposed_s) > 0.0019)
        ahead = frames.exposed_s - frames.started_cycle * CYCLE_S
        assert np.all((ahead >= 0.0) & (ahead <= FRAME_S + CYCLE_S) | (frames.started_cycle == 0))
        steps.append(np.diff(frames.exposed_s))
        means.append(delay.mean())
        spreads.append(np.mean((delay - 0.074) ** 2))
        off = delay - 0.074
        memories.append(np.mean(off[65:] * off[:-65]))
        if regime.stamped:
            drift = np.polyfit(frames.exposed_s, frames.stamp_s - frames.exposed_s, 1)
            assert abs(drift[0]) < 1.3e-4
            left = frames.stamp_s - frames.exposed_s - np.polyval(drift, frames.exposed_s)
            assert left.std() == pytest.approx(regime.stamp_s, rel=0.1)
        else:
            assert np.all(np.isnan(frames.stamp_s))
    slow = regime.drift_s > 0.0
    assert np.mean(means) == pytest.approx(0.074, abs=0.0017 if slow else 0.0008)
    wanted = 0.0 if regime.drift_s == regime.jitter_s == 0.0 else VARIATION_S
    assert np.sqrt(np.mean(spreads)) == pytest.approx(np.hypot(wanted, CYCLE_S / np.sqrt(12)), rel=0.13)
    kept = VARIATION_S**2 * np.exp(-1.0 / 5.0) if slow else 0.0
    assert np.mean(memories) == pytest.approx(kept, abs=1e-5 if slow else 2e-6)
    irregular = float(np.mean([step.std() for step in steps]))
    if not regime.triggered:
        assert irregular < 1e-9
    elif regime.jitter_s:
        assert 0.006 < irregular < 0.0095
    else:
        assert 0.0005 < irregular < 0.0016


def test_arrivals_in_order_are_the_only_thing_that_bends_the_jitter() -> None:
    """A frame that overtakes waits for the one before: a few of a hundred at 6.4 ms."""
    frames = expose(REGIMES["freerun jitter"], 40.0, np.random.default_rng(3))
    together = np.mean(np.diff(frames.read_cycle) == 0)
    assert 0.01 < together < 0.12


@pytest.mark.parametrize("noise", [0.1, 0.3, 1.0])
def test_noises_are_fractions_of_the_amplitude(noise: float) -> None:
    """Accelerometer: of w^2 times the amplitude, at each cycle, white. Image: 0.01 of the amplitude."""
    arm = replace(Arm(), range_m_s2=1e3)
    data = generate(REGIMES["freerun jitter"], noise, (5,), 20.0, arm)
    quiet = data.acceleration_m_s2 - data.motion.at(np.arange(len(data.rate_m_s)) * CYCLE_S)[2]
    unit = arm.angular_frequency**2 * arm.amplitude_m
    assert quiet.std() / unit == pytest.approx(noise, rel=0.03)
    assert abs(np.mean(quiet[1:] * quiet[:-1])) < 0.03 * quiet.var()
    seen = data.seen_m - data.motion.at(data.frames.exposed_s)[0]
    assert (seen - seen.mean()).std() / arm.amplitude_m == pytest.approx(0.01, rel=0.08)
    assert data.seen_m[0] == 0.0  # relative to the first frame, as the tracker has it


def test_the_sensor_clips_at_its_range() -> None:
    """An impact may exceed it."""
    data = generate(REGIMES["freerun constant"], 0.1, (1,), 10.0, replace(Arm(), range_m_s2=2.0))
    assert data.acceleration_m_s2.max() == 2.0
    assert data.acceleration_m_s2.min() == -2.0


def test_the_same_seed_gives_the_same_trial_and_another_gives_another() -> None:
    """To the bit."""
    first, again, other = (generate(REGIMES["triggered drift"], 0.3, (s, 1), 3.0, Arm()) for s in (7, 7, 8))
    assert np.array_equal(first.acceleration_m_s2, again.acceleration_m_s2)
    assert np.array_equal(first.frames.exposed_s, again.frames.exposed_s)
    assert not np.array_equal(first.acceleration_m_s2, other.acceleration_m_s2)


def test_lost_frames_leave_a_gap_in_the_counter() -> None:
    """The others are as they were."""
    data = generate(REGIMES["freerun drift"], 0.3, (2,), 5.0, Arm())
    lost = np.arange(len(data.frames.number)) % 10 == 3
    left = data.with_frames_lost(lost)
    assert 3 not in left.frames.number
    assert np.array_equal(left.seen_m, data.seen_m[~lost])
    assert np.array_equal(left.frames.delay_s, data.frames.delay_s[~lost])
