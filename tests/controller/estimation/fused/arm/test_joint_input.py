"""The encoder's noise, and what it does to the joint's rate, is told from what no drive can do."""

from cmath import exp as complex_exp
from math import pi, sin

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from stillarm.controller.estimation.fused.arm.joint_input import JointInput

CYCLE_S = 0.001
W = 2.0 * pi * 2.6


def after(positions: np.ndarray, cycles: list[int] | None = None) -> JointInput:
    """The joint's input after those positions, rad, one a cycle."""
    joint = JointInput([W], [-2.3 / W], CYCLE_S)
    for cycle, position in zip(cycles or range(len(positions)), positions.tolist(), strict=True):
        joint.advance(cycle, [complex_exp(1j * W * cycle * CYCLE_S)], 0.0, position)
    return joint


@settings(max_examples=20, deadline=None, derandomize=True)
@given(noise_rad=st.floats(1e-6, 1e-4), hz=st.floats(0.2, 3.0), seed=st.integers(0, 99))
def test_the_rates_variance_is_that_of_its_scatter(noise_rad: float, hz: float, seed: int) -> None:
    """White noise on a joint that swings by 0.1 rad at up to 3 Hz: the scatter of the rate about the true one."""
    random = np.random.default_rng(seed)
    times = CYCLE_S * np.arange(3000)
    joint = after(-0.1 * np.cos(2.0 * pi * hz * times) + noise_rad * random.standard_normal(3000))
    _, rates, _ = joint.seen_from(2.9, times[2100:2900])
    # a difference over 4 ms is smaller than the derivative by sin(x) / x, x the phase of 2 ms
    x = 2.0 * pi * hz * 0.002
    true = 0.1 * 2.0 * pi * hz * np.sin(2.0 * pi * hz * times[2100:2900]) * sin(x) / x
    assert joint.rate_variance == pytest.approx(float(np.mean((rates - true) ** 2)), rel=0.35)


def test_a_joint_that_moves_without_noise_has_none() -> None:
    """At 5 Hz by 0.1 rad: a rate of 3 rad/s, known to a ten thousandth of it."""
    joint = after(-0.1 * np.cos(2.0 * pi * 5.0 * CYCLE_S * np.arange(3000)))
    assert joint.rate_variance < (3e-4) ** 2


def test_a_joint_at_rest_has_none() -> None:
    assert after(np.full(1000, 0.7)).rate_variance == 0.0


def test_cycles_that_never_came_are_no_noise() -> None:
    """A joint at 1 rad/s, and 40 cycles without a word from it."""
    cycles = [*range(500), *range(540, 1000)]
    joint = after(CYCLE_S * np.array(cycles, dtype=np.float64), cycles)
    assert joint.rate_variance < 1e-3


once = settings(max_examples=15, deadline=None, derandomize=True, phases=[Phase.explicit, Phase.generate])


@once
@given(frequency_hz=st.floats(1.0, 15.0), joint_hz=st.floats(0.2, 4.0), skip=st.integers(1, 5))
def test_the_phasors_increments_move_it_as_the_modal_equation_does(
    frequency_hz: float, joint_hz: float, skip: int
) -> None:
    """Undamped q'' + w^2 q = -p L theta'' in closed form; one stretch of cycles never comes."""
    w, lever, wj = 2 * np.pi * frequency_hz, 2.3, 2 * np.pi * joint_hz
    if abs(w - wj) < 0.2 * w:
        return
    joint = JointInput([w], [-lever / w], 0.001)
    cycle = 0
    while cycle < 800:
        cycle += skip if cycle == 400 else 1
        t = cycle * 0.001
        joint.advance(cycle, [complex_exp(1j * w * t)], float(np.sin(wj * (t - 0.0005))), 0.0)
    t = cycle * 0.001
    exact = -lever / (w * w - wj * wj) * (np.sin(wj * t) - wj / w * np.sin(w * t))
    found = (joint.sum[0] * complex_exp(1j * w * t)).real
    size = lever / abs(w * w - wj * wj) * (1 + wj / w)
    assert found == pytest.approx(exact, abs=0.02 * size)


def test_instants_that_are_no_numbers_return_what_is_held() -> None:
    """NaN cast to an integer once kept numpy's take(mode="wrap") busy for ever."""
    joint = JointInput([16.0], [1.0], 0.001)
    for cycle in range(20):
        joint.advance(cycle, [1.0 + 0j], 0.0, 0.25)
    theta, rate, grown = joint.seen_from(float("nan"), np.array((float("nan"), float("inf"), -1e300)))
    assert theta.tolist() == [0.25] * 3 and rate.tolist() == [0.0] * 3
    assert np.all(np.isfinite(grown))


@pytest.mark.parametrize("cycles", (1, 2, 40, 1500))
def test_one_instant_is_read_as_many_are(cycles: int) -> None:
    """To the bit, before the first cycle and after the newest, too, and where the time is no number."""
    joint = JointInput([16.0], [1.0], 0.001)
    for cycle in range(cycles):
        joint.advance(cycle, [1.0 + 0j], 0.0, 0.3 * sin(0.02 * cycle))
    instants = [
        *np.random.default_rng(1).uniform(-0.1, 0.001 * cycles + 0.1, 200),
        float("nan"),
        1e300,
        -1e300,
    ]
    for time_s in instants:
        assert joint.position_at(time_s) == joint.seen_from(0.0, np.array((time_s,)))[0][0]
