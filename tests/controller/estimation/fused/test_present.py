"""The present beside the bank: a change of force means the same to both."""

from cmath import exp as complex_exp
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.benchmarks.estimators.trial import assumed_model
from stillarm.benchmarks.estimators.world.regimes import REGIMES
from stillarm.common.files.configuration import Fused
from stillarm.controller.estimation.fused.accelerometer.blocks import Block, Jump
from stillarm.controller.estimation.fused.arm.layout import Layout
from stillarm.controller.estimation.fused.filters import start
from stillarm.controller.estimation.fused.filters.bank import FilterBank
from stillarm.controller.estimation.fused.filters.jumps import inflate
from stillarm.controller.estimation.fused.filters.laws import QUIET
from stillarm.controller.estimation.fused.present import Present

LENGTH_M = 2.0


def ringing() -> tuple[FilterBank, Layout, Present]:
    """A bank that knows its phasor to 1 mm, and the present of the same state."""
    model = assumed_model(REGIMES["freerun drift"], 0.3)
    at = Layout(model, LENGTH_M)
    filters = FilterBank(at, start.variances(model, Fused(), at, LENGTH_M), start.jitters_s(model))
    filters.x[:, 0], filters.x[:, 1] = 0.004, -0.003
    filters.p[:, 0, 0] = filters.p[:, 1, 1] = 0.001**2
    present = Present(at.w.tolist(), at.sigma.tolist(), at.w_first)
    present.restart([0.004 + 0.003j], part(filters, at).tolist(), [0j], 0.0, 0.0, 0.0, 0.001)
    return filters, at, present


def part(filters: FilterBank, at: Layout) -> np.ndarray:
    """Covariance of a quiet filter's phasor and force."""
    i = np.array([0, 1, at.force])
    return filters.p[0][np.ix_(i, i)].copy()


@settings(max_examples=30, deadline=None, derandomize=True)
@given(
    time_s=st.floats(0.0, 60.0),
    size=st.floats(-0.03, 0.03),
    doubt=st.floats(1e-5, 0.03),
)
def test_the_present_takes_a_change_of_force_as_the_bank_does(
    time_s: float, size: float, doubt: float
) -> None:
    filters, at, present = ringing()
    jump = Jump(time_s, (0.002,), (0.0005,), doubt, size)
    inflate(filters, jump, QUIET)
    present.inflate(jump)
    assert present.z[0] == pytest.approx(complex(filters.phasors()[0, 0]), abs=1e-12)
    assert present.force == pytest.approx(float(filters.x[0, at.force]), abs=1e-15)
    assert np.allclose(present.p, part(filters, at), rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("phase", np.linspace(0.0, 2.0 * pi, 7).tolist())
def test_the_present_deflection_is_the_vibration_about_the_force(phase: float) -> None:
    """With the variance of the sum: a force just let go is known no better, but its deflection is."""
    _, at, present = ringing()
    present.restart([0.004 + 0.003j], [[0.0] * 3 for _ in range(3)], [0j], 0.0, 0.0, 0.01, 0.001)
    turn = complex_exp(1j * phase)
    jump = Jump(phase / float(at.w[0]), (0.0,), (0.0,), 0.02)
    present.inflate(jump)
    deflection, rate, std = present.deflection([turn])
    assert deflection == pytest.approx(0.01 + ((0.004 + 0.003j) * turn).real)
    assert rate == pytest.approx(((0.004 + 0.003j) * turn * 1j * float(at.w[0])).real)
    assert std == pytest.approx(0.0, abs=1e-9)
    _, _, half_a_period_later = present.deflection([-turn])
    assert half_a_period_later == pytest.approx(0.04)


def test_the_accelerometer_moves_a_force_only_so_far_as_it_is_correlated_with_the_phasor() -> None:
    """It does not show the force itself."""
    _, _, present = ringing()
    present._update([1.0, 0.0, 0.0], 0.001, 1e-6, None)
    assert present.force == 0.0
    present.inflate(Jump(0.0, (0.0,), (0.0,), 0.01))
    before = present.z[0]
    present._update([1.0, 0.0, 0.0], 0.001, 1e-6, None)
    assert present.force == pytest.approx(-(present.z[0] - before).real, rel=0.02)
    assert present.force < -0.0005


@settings(max_examples=50, deadline=None, derandomize=True)
@given(
    share=st.floats(-0.9, 0.9),
    phase=st.floats(0.0, 6.3),
    value_m=st.floats(-0.01, 0.01),
    shown=st.none() | st.tuples(st.floats(-1e-7, 1e-7), st.floats(-1e-7, 1e-7)),
)
def test_a_block_says_of_one_mode_what_it_says_beside_a_force_that_is_known(
    share: float, phase: float, value_m: float, shown: tuple[float, float] | None
) -> None:
    """Two states written out, and three of which the last has no variance: phasor and covariance are the same."""
    w = 2.0 * pi * 2.6
    turn = complex_exp(1j * phase)
    block = Block(1.0, 1.016, 16, value_m, (turn,), 1.008, 0.0, 1e-7, (0j,))
    presents = []
    for states in (2, 3):
        p = [[0.0] * states for _ in range(states)]
        p[0][0], p[1][1], p[0][1], p[1][0] = 4e-6, 1e-6, share * 2e-6, share * 2e-6
        present = Present([w], [0.16], w)
        present.restart([0.004 + 0.003j], p, [-0.16 + 0.1j], 0.0, 0.0, 0.0, 0.001)
        present.update_by_block(block, 1e-6, shown, at_end=False)
        presents.append(present)
    one, beside = presents
    assert one.z[0] == pytest.approx(beside.z[0], abs=1e-15)
    assert np.allclose(one.p, np.array(beside.p)[:2, :2], rtol=1e-12, atol=1e-20)
    assert one.z[0] != 0.004 + 0.003j and beside.force == 0.0
