"""Terms in amounts to be fitted: hats that join up to straight lines, and a mode that answers as an integrator says."""

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from stillarm.diagnosis.physics.linear_modes import answer_of_mode
from stillarm.diagnosis.physics.space import Added, hats

STEP_S = 0.001


def test_a_group_names_one_amount_for_each_column() -> None:
    group = Added("free.position", {"acceleration": np.zeros((5, 3))}, 1.0)
    assert group.amounts == ("free.position.0", "free.position.1", "free.position.2")


@given(st.integers(2, 9), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_hats_join_up_to_any_straight_line(knots: int, slope: float, offset: float) -> None:
    at = np.linspace(0.0, 7.0, knots)
    time = np.linspace(0.0, 7.0, 101)
    columns = hats(time, at)
    assert columns.shape == (101, knots)
    assert columns @ (slope * at + offset) == pytest.approx(slope * time + offset, abs=1e-12)
    assert np.all((columns >= 0.0) & (columns <= 1.0))


def test_a_hat_is_one_at_its_knot_and_nothing_at_the_others() -> None:
    at = np.array([0.0, 0.5, 2.0, 3.0])
    assert hats(at, at) == pytest.approx(np.eye(4))


@pytest.mark.slow
@pytest.mark.parametrize(("hz", "damping"), [(2.6, 0.004), (2.6, 0.3), (12.0, 0.02)])
def test_a_mode_answers_as_an_integrator_says(hz: float, damping: float) -> None:
    """q'' + 2 zeta w q' + w^2 q = f, from rest, under a force that begins softly."""
    w, time = 2.0 * pi * hz, np.arange(3000) * STEP_S

    def force(t: float) -> float:
        return float(5.0 * np.sin(9.0 * t) ** 2 * np.exp(-0.3 * t))

    solved = solve_ivp(
        lambda t, y: [y[1], force(t) - 2.0 * damping * w * y[1] - w * w * y[0]],
        (0.0, time[-1]),
        [0.0, 0.0],
        t_eval=time,
        rtol=1e-10,
        atol=1e-13,
    )
    forces = np.array([force(t) for t in time])
    q, second = answer_of_mode(np.stack([forces, -2.0 * forces], axis=1), hz, damping, STEP_S)
    rate = forces - 2.0 * damping * w * solved.y[1] - w * w * solved.y[0]
    allowed = (w * STEP_S) ** 2 / 12.0 * w * time[-1] + 1e-3  # phase by which the bilinear frequency is off
    assert np.max(np.abs(q[:, 0] - solved.y[0])) < allowed * np.max(np.abs(solved.y[0]))
    assert np.max(np.abs(second[:, 0] - rate)) < allowed * np.max(np.abs(rate))
    assert q[:, 1] == pytest.approx(-2.0 * q[:, 0])


def test_a_steady_force_bends_a_mode_by_its_stiffness() -> None:
    q, second = answer_of_mode(np.full((20000, 1), 3.0), 2.0, 0.2, STEP_S)
    assert q[-1, 0] == pytest.approx(3.0 / (4.0 * pi) ** 2)
    assert second[-1, 0] == pytest.approx(0.0, abs=1e-9)
