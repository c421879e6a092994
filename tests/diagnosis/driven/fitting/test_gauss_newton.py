"""Steps of a fit within their bounds."""

import numpy as np
import pytest

from stillarm.diagnosis.driven.fitting.gauss_newton import orthonormal, stepped
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.recording.signals import Driven, Output

POSITION = Output("joint_position_rad", "position", np.zeros(900), True, 0.0)
BOX = GreyBox(
    Driven("x", 0.01, 0.0, "joint_torque_n_m", np.zeros(900), True, (POSITION,), {}), irregular(9.0)
)
NORMAL, GRADIENT = np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([1.0, -4.0])


def test_what_a_bound_stops_stays_there_and_the_others_step_as_suits_that() -> None:
    """The least of x' N x / 2 - g' x where damping, 0.1 now, is never negative: by hand (1 + 0.1) / 2."""
    trial, moved = stepped(BOX, {"gain": 1.0, "damping": 0.1}, ("gain", "damping"), NORMAL, GRADIENT)
    assert trial == pytest.approx({"gain": 1.55, "damping": 0.0})
    assert moved == pytest.approx([0.55, -0.1])


def test_without_a_bound_a_step_is_the_normal_equations() -> None:
    _, moved = stepped(BOX, {"gain": 1.0, "damping": 9.0}, ("gain", "damping"), NORMAL, GRADIENT)
    assert NORMAL @ moved == pytest.approx(GRADIENT)


def test_columns_that_others_make_up_are_left_out() -> None:
    column = np.arange(5.0)
    q = orthonormal(np.column_stack([column, np.ones(5), 3.0 * column]))
    assert q.shape == (5, 2) and q.T @ q == pytest.approx(np.eye(2))
