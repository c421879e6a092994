"""Motions under a hand: they obey the mode's equation."""

import numpy as np
import pytest

from stillarm.benchmarks.estimators.trial import scored_cycles, swinging_cycles
from stillarm.benchmarks.estimators.world.excitation import (
    FIRST_S,
    pulled_slowly_at,
    pushed_again,
    released_again,
    struck_once,
)
from stillarm.benchmarks.estimators.world.generator import Excitation, Motion, generate
from stillarm.benchmarks.estimators.world.regimes import CYCLE_S, REGIMES, Arm

EXCITATIONS = [released_again, pushed_again, struck_once, pulled_slowly_at(7.0)]


def drawn(excite: Excitation, seed: int) -> Motion:
    """A motion of 12 s."""
    return excite(Arm(), 12.0, np.random.default_rng(seed))


@pytest.mark.parametrize("excite", EXCITATIONS)
@pytest.mark.parametrize("seed", range(4))
def test_the_motion_obeys_the_modes_equation_under_a_hand(excite: Excitation, seed: int) -> None:
    """q' is the slope of q, q'' that of q'; q'' + 2 zeta w q' + w^2 q is the force; no jumps; the force as told."""
    arm, motion, h = Arm(), drawn(excite, seed), 1e-5
    time = np.linspace(0.01, 12.0, 3000)
    time = time[np.min(np.abs(time[:, None] - motion.start_s[None, :]), axis=1) > 3 * h]
    q, v, a = motion.at(time)
    before, after = motion.at(time - h), motion.at(time + h)
    assert (after[0] - before[0]) / (2 * h) == pytest.approx(v, abs=1e-6)
    assert (after[1] - before[1]) / (2 * h) == pytest.approx(a, abs=1e-3)
    w, row = arm.angular_frequency, motion.piece_at(time)
    force = motion.force_m_s2[row] + motion.force_rate_m_s3[row] * (time - motion.start_s[row])
    assert a + 2 * arm.damping_ratio * w * v + w**2 * q == pytest.approx(force, abs=1e-9)
    for start in motion.start_s[1:]:
        left, right = motion.at(np.array([start - 1e-9])), motion.at(np.array([start + 1e-9]))
        assert left[0] == pytest.approx(right[0], abs=1e-8)
        assert left[1] == pytest.approx(right[1], abs=1e-6)


def test_a_held_arm_is_seen_bent_and_felt_still() -> None:
    """Before the release: images show force / w^2, the accelerometer next to nothing; after it w^2 times as much."""
    arm = Arm()
    for seed in range(8):
        motion = drawn(released_again, seed)
        let_go = motion.forced_s[0, 1]
        held, free = motion.at(np.array([let_go - 0.01])), motion.at(np.array([let_go + 0.001]))
        bent = abs(held[0][0]) / arm.amplitude_m
        assert 0.8 < bent < 1.7
        assert abs(held[2][0]) < 0.2 * bent * arm.angular_frequency**2 * arm.amplitude_m
        assert free[2][0] == pytest.approx(-(arm.angular_frequency**2) * held[0][0], rel=0.1)
        ringing = motion.at(let_go + np.linspace(0.0, 1.0, 500))
        assert np.hypot(ringing[0], ringing[1] / arm.angular_frequency)[-1] > 0.6 * bent * arm.amplitude_m


@pytest.mark.parametrize("excite", [released_again, pushed_again, struck_once])
def test_an_arm_at_rest_stays_so_until_it_is_touched(excite: Excitation) -> None:
    """Rest is not scored, nor is a hand's force; what rings after either is."""
    data = generate(REGIMES["freerun drift"], 0.3, (3,), 12.0, Arm(), None, excite)
    first, end = data.motion.forced_s[0]
    assert first >= FIRST_S
    assert np.all(data.amplitude_m[: int(first / CYCLE_S)] == 0.0)
    scored = scored_cycles(data)
    assert not scored[: int((end + 0.49) / CYCLE_S)].any()
    assert scored[int((end + 0.52) / CYCLE_S) :][:1000].all()
    assert np.all(data.amplitude_m[swinging_cycles(data, 0.0)] > 0.0)


def test_the_slow_pull_leaves_what_was_before_as_it_was() -> None:
    """Impacts as usual until a second before."""
    data = generate(REGIMES["freerun drift"], 0.3, (3,), 16.0, Arm(), None, pulled_slowly_at(9.0))
    pull = data.motion.forced_s
    assert pull.shape == (1, 2)
    assert pull[0, 0] == 9.0
    assert 3.0 < pull[0, 1] - 9.0 < 6.1
    assert len(data.motion.impacts_s) >= 3
    assert np.all(data.motion.impacts_s[:-1] < 8.1)
