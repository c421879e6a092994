"""The integrator against scipy's, with laws that bend."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.hidden_world.rigs.dynamics import LINK, STATES, Laws, Q, V, kinetics, slope
from tests.hidden_world.rigs.rig import FINE, STEP_S, TICK_S, Values

pytestmark = pytest.mark.slow

W = 2.0 * np.pi * 3.1
MODES = np.array([[W, 0.01, 1.2, 1.0], [6.1 * W, 0.006, -0.17, 0.8]])
PLAIN = Laws(1.7, 120.0, 120.0)
CYCLES = 1500
COMMAND = np.where(np.arange(CYCLES * FINE) >= round(0.2 / STEP_S), 0.3, 0.0)
PUSH_S = 0.6


def push(t: float) -> float:
    """A tip force, m/s^2, that is smooth."""
    return float(3.0 * np.exp(-(((t - PUSH_S) / 0.05) ** 2)))


FORCE = np.array([push(0.5 * STEP_S * k) for k in range(2 * CYCLES * FINE + 1)])
STIFF = np.ones(CYCLES)


def paper(t: float, x: Values, laws: Laws) -> Values:
    """The equations of dynamics.py's head, written anew for those laws that are asked about here."""
    command = 0.3 if t > 0.2 else 0.0
    q, v = x[4:6], x[6:8]
    alpha = laws.lag_up * (command - x[1])
    w, z, share, own = MODES.T
    bend = -(w**2) * q - 2.0 * z * w * v + own * push(t) - share * laws.length_m * alpha
    bend[0] -= w[0] ** 2 * (laws.cubic * q[0] ** 3 + laws.fifth * q[0] ** 5 + laws.skew * q[0] ** 2)
    bend[0] -= laws.power_damping * abs(v[0]) ** (laws.power - 1.0) * v[0]
    bend[0] -= (
        laws.coulomb * np.tanh(v[0] / laws.coulomb_width) + w[0] ** 2 * laws.centrifugal * x[1] ** 2 * q[0]
    )
    bend[0] += laws.side_back * w[0] ** 2 * x[8]
    side = -laws.side_w * (2.0 * laws.side_z * x[9] + laws.side_w * x[8])
    side += laws.side_from_bending * w[0] ** 2 * q[0] - laws.side_from_joint * alpha
    return np.array([x[1], alpha, 0.0, 0.0, *v, *bend, x[9], side])


@pytest.mark.parametrize(
    "laws",
    [
        PLAIN,
        PLAIN._replace(cubic=150.0, fifth=-800.0),
        PLAIN._replace(power_damping=2.0, power=1.9),
        PLAIN._replace(coulomb=0.05, coulomb_width=0.02, centrifugal=-0.8, skew=2.0),
        PLAIN._replace(
            side_w=1.2 * W, side_z=0.02, side_from_bending=0.1, side_back=0.1, side_from_joint=0.3
        ),
    ],
    ids=["plain", "cubic", "quadratic", "coulomb", "side"],
)
def test_motion_is_what_a_general_integrator_gives(laws: Laws) -> None:
    rows, _ = kinetics(np.zeros(STATES), COMMAND, FORCE, STIFF, STIFF, laws, MODES)
    start, ends = np.zeros(10), [0.0, 0.2, CYCLES * TICK_S]
    for begin, end in pairwise(ends):  # the command jumps between
        solved = solve_ivp(
            lambda t, x: paper(t, x, laws),
            (begin + 1e-12, end),
            start,
            "DOP853",
            rtol=1e-11,
            atol=1e-14,
            max_step=0.01,
        )
        start = solved.y[:, -1]
    got = rows[-1]
    scale = np.max(np.abs(rows[:, Q]))
    assert np.abs(got[Q : Q + 2] - start[4:6]).max() < 1e-6 * scale
    assert np.abs(got[V : V + 2] - start[6:8]).max() < 1e-6 * scale * MODES[1, 0]
    assert abs(got[LINK] - start[0]) < 1e-9


def steady_loop(laws: Laws) -> Values:
    """Force over deflection in a slow cycle of the first mode, by slope() alone: where the arm rests at each force."""
    x, out = np.zeros(STATES), []
    for q, v in ((0.01, 1.0), (0.01, -1.0), (-0.01, 1.0), (-0.01, -1.0)):
        x[Q], x[V], d = q, v * 1e-9, np.zeros(STATES)
        slope(0.0, x, 0.0, 0.0, 1.0, 1.0, laws, *np.ascontiguousarray(MODES[:1].T), d)
        out.append(d[V])
    return np.array(out)


def test_two_slopes_are_two_stiffnesses() -> None:
    force = steady_loop(PLAIN._replace(side_step=0.1)) / (-W * W * 0.01)
    assert force == pytest.approx([1.1, 1.1, -0.9, -0.9], rel=1e-6)


def test_a_stop_is_felt_on_its_side_alone() -> None:
    force = steady_loop(PLAIN._replace(stop_m=0.004, stop_stiffness=2.0)) / (-W * W * 0.01)
    assert force == pytest.approx([2.2, 2.2, -1.0, -1.0], rel=1e-6)


def driven(laws: Laws, command: Callable[[Values], Values]) -> tuple[Values, Values]:
    """Motor and link speed under a command of time."""
    t = np.arange(CYCLES * FINE) * STEP_S
    rows, _ = kinetics(np.zeros(STATES), command(t), np.zeros_like(FORCE), STIFF, STIFF, laws, MODES)
    return rows[:, 1], rows[:, 3]


def test_coulomb_friction_costs_a_constant_speed() -> None:
    motor, _ = driven(
        PLAIN._replace(friction_up=120.0 * 0.05, friction_down=120.0 * 0.05),
        lambda t: np.where(t > 0.2, 0.3, 0.0),
    )
    assert motor[-1] == pytest.approx(0.25, rel=1e-6)


def test_acceleration_is_limited_by_direction() -> None:
    motor, _ = driven(PLAIN._replace(most_up=2.0), lambda t: 0.5 * np.sign(np.sin(9.0 * t)))
    rate = np.diff(motor) / STEP_S
    assert np.max(rate) == pytest.approx(2.0, rel=1e-6) and np.min(rate) < -10.0


def test_a_link_behind_a_play_stands_while_the_motor_crosses_it() -> None:
    w = 2.0 * np.pi * 70.0
    laws = PLAIN._replace(gap=0.02, gear_stiffness=w * w, gear_damping=1.6 * w, gear_drag=200.0)
    motor, link = driven(laws, lambda t: np.full(len(t), 0.1))
    crossed = int(np.argmax(np.abs(link) > 1e-9)) * STEP_S
    assert np.sum(motor[: int(crossed / STEP_S)]) * STEP_S == pytest.approx(0.01, rel=0.01)
    assert link[-1] == pytest.approx(0.1, rel=0.01)
