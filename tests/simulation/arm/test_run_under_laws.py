"""Modes under laws over a whole recording, beside the same cycles by the stepper."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from stillarm.common.causes import LAWS
from stillarm.common.files.model import Drive
from stillarm.simulation.arm.compiled_laws import laws_of
from stillarm.simulation.arm.free_run import free_run
from stillarm.simulation.arm.state import make_arm

Array = NDArray[np.float64]

DT, CYCLES = 0.001, 6000
OF_A_DRIFT = 1e-5
"""A frequency taken for constant in a cycle is off by dt^2 w'/6 of the amplitude a second (Magnus' second term): w' is
up to 16 rad/s^2 here."""
DRIVE = Drive(
    bandwidth_hz=20.0,
    dead_time_s=0.0023,
    max_velocity_rad_s=1e9,
    max_acceleration_rad_s2=1e3,
    min_position_rad=-10.0,
    max_position_rad=10.0,
)
MODES = np.array([[2.6, 0.01, 1.3], [17.0, 0.008, -0.2]])
JUMPS_AT = np.array([0, 2500], dtype=np.int64)
JUMPS = np.array([[[0.02, 0.3], [1e-3, 0.0]], [[0.0, 0.1], [0.0, 0.05]]])


def motions(cause: str, values: dict[str, Any], begin_s: float = 0.0) -> tuple[Array, Array]:
    """q and q'', (n, 4), as the whole recording's functions have them, and as the stepper does."""
    command = np.repeat(np.random.default_rng(1).normal(0.0, 0.3, CYCLES // 100), 100)
    found = []
    for stepped in (False, True):
        arm, whole = make_arm(DRIVE, DT, MODES, laws_of([(cause, values)], begin_s))
        if stepped:
            arm["c2"] = 1e-300  # a force of no size: the stepper has to look at it
        outs = [np.zeros((CYCLES, width)) for width in (4, 2, 2, 2)]
        free_run(arm, command, whole, JUMPS_AT, JUMPS, *outs)
        found.append(np.hstack(outs[2:]))
    return found[0], found[1]


def assert_alike(mine: Array, judge: Array, least: float) -> None:
    assert np.max(np.abs(mine - judge) / np.max(np.abs(judge), axis=0)) < least


@settings(max_examples=15, deadline=None)
@given(rate=st.floats(-0.2, 0.4), share=st.floats(0.0, 1.5), begin_s=st.floats(0.0, 5.0))
def test_a_frequency_that_drifts(rate: float, share: float, begin_s: float) -> None:
    values = {"frequency_rate_hz_per_s": rate, "higher_modes_share": share}
    assert_alike(*motions("stiffness_drift", values, begin_s), OF_A_DRIFT)


@pytest.mark.parametrize(
    ("cause", "values"),
    [
        ("stiffness_drift", {"frequency_rate_hz_per_s": 0.05, "higher_modes_share": 1.0}),
        (
            "modal_temperature_drift",
            {"time_constant_s": 1.5, "relative_change": 0.03, "higher_modes_share": 1.0},
        ),
    ],
)
def test_a_drift_counts_time_from_its_onset(cause: str, values: dict[str, float]) -> None:
    """An arm that is struck then rings as one that is struck at the start, where the drift has begun."""
    onset = 2000

    def struck(at: int) -> Array:
        arm, whole = make_arm(DRIVE, DT, MODES, laws_of([(cause, values)], at * DT))
        outs = [np.zeros((CYCLES, width)) for width in (4, 2, 2, 2)]
        free_run(arm, np.zeros(CYCLES), whole, np.array([at]), JUMPS[:1], *outs)
        return np.hstack(outs[2:])

    assert_alike(struck(onset)[onset:], struck(0)[:-onset], OF_A_DRIFT)


@settings(max_examples=15, deadline=None)
@given(lasts_s=st.floats(0.1, 30.0), change=st.floats(-0.1, 0.1))
def test_a_frequency_that_levels_off(lasts_s: float, change: float) -> None:
    values = {"time_constant_s": lasts_s, "relative_change": change, "higher_modes_share": 1.0}
    assert_alike(*motions("modal_temperature_drift", values), OF_A_DRIFT)


@settings(max_examples=15, deadline=None)
@given(onset_s=st.floats(0.0, 6.0), ratio=st.floats(0.8, 1.2))
def test_a_frequency_that_jumps_within_a_cycle(onset_s: float, ratio: float) -> None:
    values = {"onset_s": onset_s, "frequency_ratio": ratio, "higher_modes_share": 1.0}
    assert_alike(*motions("payload_change", values), 1e-7)


@pytest.mark.parametrize(
    ("cause", "values"),
    [
        ("cubic_stiffness", {"coefficient_per_m2": 500.0}),
        ("quadratic_damping", {"coefficient_per_m": 5.0}),
        ("coulomb_damping", {"force_per_mass_m_s2": 0.3}),
    ],
)
def test_a_force_is_stepped_as_before(cause: str, values: dict[str, float]) -> None:
    assert_alike(*motions(cause, values), 1e-9)


@pytest.mark.parametrize("begin_s", [0.0, 1.23456])
@pytest.mark.parametrize(
    ("cause", "values"),
    [
        ("periodic_disturbance", {"frequency_hz": 8.3, "amplitude_m_s2": 0.6, "phase_rad": 0.7}),
        ("rotor_imbalance", {"gear_ratio": 60.0, "imbalance_m": 1e-3, "phase_rad": 0.7}),
    ],
)
def test_a_foreign_force_is_an_input(cause: str, values: dict[str, float], begin_s: float) -> None:
    assert_alike(*motions(cause, values, begin_s), 1e-6)


def test_forces_that_follow_from_time_and_joint_alone_are_declared_so() -> None:
    generator = np.random.default_rng(3)
    for cause in LAWS.values():
        if cause.acts != "force" or cause.law is None:
            continue
        own = [max(one.typical[0], 1e-3) for one in cause.numbers]
        joint = [(t, theta, omega) for t, theta, omega in generator.uniform(0.1, 1.0, (20, 3))]
        modes = generator.uniform(0.1, 1.0, (2, 20, 3))
        one, other = ([cause.law(*j, *m, *own) for j, m in zip(joint, mode, strict=True)] for mode in modes)
        assert (one == other) == cause.foreign, cause.identifier
