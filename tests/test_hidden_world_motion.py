"""The hidden world's integrator against solutions on paper and against scipy."""

from math import exp, pi, sqrt

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from tests.hidden_world.motion import WIDTH, Works, move
from tests.hidden_world.rig import FINE, STEP_S, TICK_S, tip_slope

pytestmark = pytest.mark.slow

Array = NDArray[np.float64]
W = 2.0 * pi * 2.6
PLAIN = Works(
    reach=2.0, w1=W, z1=0.01, p1=1.14, w2=0.0, z2=0.0, p2=0.0, lag=125.0, top_acceleration=1e6, top_speed=9.0
)
CYCLES = 3000


def moved(
    works: Works,
    reference: Array | None = None,
    bending: float = 0.0,
    hold_up_s: float = 0.0024,
    impacts: dict[float, float] | None = None,
    push: Array | None = None,
) -> Array:
    reference = np.zeros(CYCLES) if reference is None else reference
    cycles, start, impacts = len(reference), np.zeros(WIDTH), impacts or {}
    start[2] = bending
    fine = cycles * FINE + 1
    rows, _ = move(
        works,
        start,
        reference,
        np.full(cycles, hold_up_s),
        np.zeros(cycles),
        np.zeros(cycles),
        1.0,
        np.array(sorted(impacts)),
        np.array([impacts[t] for t in sorted(impacts)]),
        np.ones(fine),
        np.zeros(fine) if push is None else push,
    )
    return np.asarray(rows)


def test_ring_down_is_the_damped_sine() -> None:
    rows = moved(PLAIN, bending=0.02)
    t = np.arange(len(rows)) * STEP_S
    wd = W * sqrt(1.0 - 1e-4)
    exact = 0.02 * np.exp(-0.01 * W * t) * (np.cos(wd * t) + 0.01 * W / wd * np.sin(wd * t))
    assert np.max(np.abs(rows[:, 2] - exact)) < 1e-10


def test_a_step_of_the_command_reaches_the_drive_after_its_hold_up_exactly() -> None:
    reference = np.zeros(CYCLES)
    reference[100:] = 0.3
    rows = moved(PLAIN, reference, hold_up_s=0.00237)
    t = np.arange(len(rows)) * STEP_S - (100 * TICK_S + 0.00237)
    exact = np.where(t > 0.0, 0.3 * (1.0 - np.exp(-125.0 * np.maximum(t, 0.0))), 0.0)
    assert np.max(np.abs(rows[:, 1] - exact)) < 1e-9


def test_an_impact_between_steps_starts_the_swing_at_its_instant() -> None:
    at = 0.512345
    rows = moved(PLAIN._replace(z1=0.0), impacts={at: 0.1})
    t = np.maximum(np.arange(len(rows)) * STEP_S - at, 0.0)
    assert np.max(np.abs(rows[:, 2] - 0.1 / W * np.sin(W * t))) < 1e-10


def test_cubic_stiffness_keeps_its_energy() -> None:
    c = 400.0
    rows = moved(PLAIN._replace(z1=0.0, cubic=c), bending=0.03)
    q, v = rows[:, 2], rows[:, 3]
    energy = 0.5 * v**2 + W * W * (0.5 * q**2 + 0.25 * c * q**4)
    assert np.ptp(energy) < 1e-9 * energy[0]


def test_dry_friction_takes_four_times_its_width_off_every_swing_and_then_sticks() -> None:
    force = 0.03 * W * W * 0.02  # 3 % of the first swing: the peak falls by 2 F / w^2 every half swing
    rows = moved(PLAIN._replace(z1=0.0, dry=force), bending=0.02)
    q = rows[:, 2]
    half = pi / W
    for swing in range(1, 8):
        peak = q[round(swing * half / STEP_S)]
        assert abs(peak) == pytest.approx(0.02 - 2.0 * swing * force / (W * W), rel=1e-5)
    late = moved(PLAIN._replace(z1=0.0, dry=force * 4.0), bending=0.02)
    assert np.all(late[-1000:, 3] == 0.0)
    assert abs(late[-1, 2]) < 4.0 * force / (W * W)


def test_joint_friction_takes_its_loss_off_the_speed_and_holds_below_it() -> None:
    reference = np.concatenate([np.full(1000, 0.1), np.full(1000, 0.009), np.full(1000, -0.1)])
    rows = moved(PLAIN._replace(drag=0.01), reference)
    assert rows[9000, 1] == pytest.approx(0.09, rel=1e-6)
    assert rows[19000, 1] == 0.0
    assert rows[-1, 1] == pytest.approx(-0.09, rel=1e-6)


def test_play_leaves_the_link_behind_by_half_the_gap_and_loses_the_gap_at_a_reversal() -> None:
    reference = np.concatenate([np.full(1500, 0.05), np.full(1500, -0.05)])
    rows = moved(PLAIN._replace(play=0.002), reference)
    assert rows[14000, 0] - rows[14000, 6] == pytest.approx(0.001, abs=1e-6)
    assert rows[-1, 0] - rows[-1, 6] == pytest.approx(-0.001, abs=1e-6)


def test_two_bends_and_a_moving_joint_agree_with_another_solver() -> None:
    works = PLAIN._replace(w2=2.0 * pi * 16.3, z2=0.02, p2=-0.14, lag=125.0, drag2=0.8, cubic=300.0)
    random = np.random.default_rng(4)
    reference = np.repeat(random.uniform(-0.2, 0.2, 12), 50)
    rows = moved(works, reference, bending=0.01)

    def slope(t: float, x: Array, held: float) -> list[float]:
        joint = 125.0 * (held - x[1])
        first = -W * W * (x[2] + 300.0 * x[2] ** 3) - 0.02 * W * x[3] - 0.8 * x[3] * abs(x[3]) - 2.28 * joint
        second = -(works.w2**2) * x[4] - 0.04 * works.w2 * x[5] + 0.28 * joint
        return [x[1], joint, x[3], first, x[5], second]

    state, edges = np.array([0.0, 0.0, 0.01, 0.0, 0.0, 0.0]), [0.0]
    edges += [0.05 * k + 0.0024 for k in range(12)] + [0.6]
    for place in range(len(edges) - 1):
        held = 0.0 if place == 0 else reference[50 * (place - 1)]
        span = (edges[place], edges[place + 1])
        state = solve_ivp(slope, span, state, args=(held,), rtol=1e-11, atol=1e-14, method="DOP853").y[:, -1]
    assert rows[-1, :6] == pytest.approx(state, rel=1e-7, abs=1e-10)


def test_a_push_at_resonance_builds_up_as_on_paper() -> None:
    works = PLAIN._replace(z1=0.02)
    t = np.arange(CYCLES * FINE + 1) * STEP_S
    rows = moved(works, push=0.5 * np.sin(W * t))
    steady = 0.5 / (2.0 * 0.02 * W * W)
    swung = np.max(np.abs(rows[-5000:, 2]))
    assert swung == pytest.approx(steady * (1.0 - exp(-0.02 * W * (t[-1] - 0.1))), rel=0.01)


def test_slope_of_a_uniform_beam() -> None:
    """Blevins, Formulas for Natural Frequency and Mode Shape, table 8-1: slope / deflection = root * sigma."""
    assert tip_slope(0) == pytest.approx(1.87510407 * 0.734095514, rel=1e-6)
    assert tip_slope(1) == pytest.approx(4.69409113 * 1.018467319, rel=1e-6)
