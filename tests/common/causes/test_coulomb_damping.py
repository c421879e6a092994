"""Dry friction: what it takes off each half swing, and what it holds."""

from math import exp, pi, sin

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stillarm.common.files.model import Mode
from tests.fixtures.shaken_arm import CYCLE_S, Array, W, arm, rings
from tests.reference.effects_judge import TOLERANCES, ringing


def test_coulomb_damping_takes_the_same_off_every_half_swing_and_then_holds() -> None:
    """Without other damping each half swing loses 2 F / w^2; at rest the force holds what pulls less than it."""
    force = 0.1
    plant = arm(
        {"cause": "coulomb_damping", "force_per_mass_m_s2": force},
        modes=[Mode(frequency_hz=2.6, damping_ratio=0.0)],
    )
    _, found = rings(plant, 0.008, 6000)
    peaks = np.flatnonzero(
        (np.abs(found[1:-1]) > np.abs(found[:-2])) & (np.abs(found[1:-1]) >= np.abs(found[2:]))
    )
    heights = np.abs(found[1:-1])[peaks]
    assert len(heights) > 8
    # the struck quarter swing first: (A0 + F/w^2)^2 = (v/w)^2 + (F/w^2)^2
    shift = force / W**2
    assert heights[0] == pytest.approx(
        np.hypot(0.008, shift) - shift, abs=2e-7
    )  # a peak lies between two samples
    assert np.diff(heights[:8]) == pytest.approx(np.full(7, -2.0 * shift), abs=2e-7)
    assert plant.modal_rates_m_s == [0.0]
    assert np.ptp(found[-2000:]) == 0.0
    assert 0.0 < abs(found[-1]) < shift
    assert plant.tip_acceleration_m_s2 == 0.0


@pytest.mark.slow
def test_coulomb_damping_under_a_moving_joint() -> None:
    """Against a fine step-by-step integration that knows nothing of stretches: 400000 steps a second."""
    force, fine = 0.2, 400
    commands = [0.05 if (n // 170) % 2 else -0.03 for n in range(900)]
    plant = arm({"cause": "coulomb_damping", "force_per_mass_m_s2": force})
    step, lag = CYCLE_S / fine, 2.0 * pi * 20.0
    q = rate = velocity = 0.0
    for command in commands:
        plant.advance(command)
        for _ in range(fine):
            acceleration = lag * (command - velocity) * exp(-0.5 * lag * step)
            velocity += acceleration * step
            pull = -W * W * q - 0.02 * W * rate - 1.14 * 2.0 * acceleration
            if rate == 0.0 and abs(pull) <= force:
                continue
            sign = np.sign(rate) if rate != 0.0 else np.sign(pull)
            new = rate + step * (pull - sign * force)
            rate = 0.0 if rate != 0.0 and new * rate < 0.0 else new
            q += step * rate
        assert plant.deflection_m == pytest.approx(q, abs=2e-6)  # of some 20 mm: the judge is of first order


def test_what_friction_holds_stays_where_it_is_and_what_it_does_not_moves() -> None:
    """A swelling force against dry friction: at rest to the bit below it, and moving above it, as scipy has it."""
    friction = {"cause": "coulomb_damping", "force_per_mass_m_s2": 0.3}
    push = {"cause": "periodic_disturbance", "frequency_hz": 0.5, "amplitude_m_s2": 0.29}
    plant = arm(friction, push)
    for _ in range(2000):
        plant.advance(0.0)
    assert (plant.deflection_m, plant.tip_acceleration_m_s2) == (0.0, 0.0)
    plant = arm(friction, {**push, "amplitude_m_s2": 0.6})
    found = []
    for _ in range(700):
        plant.advance(0.0)
        found.append(plant.deflection_m)
    away = 1000.0 / 6.0  # sin(pi t) reaches 0.3 / 0.6, ms
    assert set(found[: int(away)]) == {0.0}
    rising = np.arange(int(away) + 1, 330) * CYCLE_S
    from_s = away * CYCLE_S
    wanted = ringing(0.0, rising - from_s, force=lambda t, w, q, v: 0.6 * sin(pi * (t + from_s)) - 0.3)
    assert np.max(np.abs(np.array(found[int(away) : 329]) - wanted)) < 2e-3 * np.max(np.abs(wanted))


def test_dry_friction_beside_the_other_forces() -> None:
    """With cubic stiffness and quadratic damping, up to the first reversal and on to the second, by scipy."""
    effects = (
        {"cause": "cubic_stiffness", "coefficient_per_m2": 900.0},
        {"cause": "quadratic_damping", "coefficient_per_m": 8.0},
    )
    plant = arm({"cause": "coulomb_damping", "force_per_mass_m_s2": 0.3}, *effects)
    _, found = rings(plant, 0.02, 250)
    w = 2.0 * pi * 2.6

    def slope(time: float, state: Array) -> list[float]:
        q, v = state
        push = -w * w * q * (1.0 + 900.0 * q * q) - 0.02 * w * v - 8.0 * v * abs(v)
        return [v, push - 0.3 * direction]

    def reversal(time: float, state: Array) -> float:
        return float(state[1])

    reversal.terminal = True  # type: ignore[attr-defined]
    state, begin, end, wanted = np.array([0.0, w * 0.02]), 0.0, 0.25, np.zeros(251)
    for direction in (1.0, -1.0):
        reversal.direction = -direction  # type: ignore[attr-defined]
        solution = solve_ivp(slope, (begin, end), state, events=reversal, dense_output=True, **TOLERANCES)
        inside = np.arange(251) * CYCLE_S
        now = (inside >= begin) & (inside <= solution.t[-1])
        wanted[now] = solution.sol(inside[now])[0]
        state, begin = np.array([solution.y[0, -1], 0.0]), float(solution.t[-1])
    assert begin == end
    assert np.max(np.abs(found - wanted)) < 3e-5 * 0.02
