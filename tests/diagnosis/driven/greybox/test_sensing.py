"""Late sensors against the exact answer of a lag and a delay to an acceleration that jumps with a held input."""

from dataclasses import replace
from math import exp

import numpy as np
import pytest

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.greybox.sensing import is_late, jump_shown
from stillarm.diagnosis.driven.recording.signals import Driven, Output

STEP_S, SAMPLES, LAG_S = 0.02, 300, 0.008
NAME = "acceleration_m_s2"
NUMBERS = {"gain": 2.0, "damping": 0.0, "held": 1.0, f"direct {NAME}": 1.0}
ACCELEROMETER = Output(NAME, "acceleration", np.zeros(SAMPLES), True, 0.0)


def _box(values: np.ndarray, edges_s: tuple[float, ...] = (0.0, STEP_S * SAMPLES)) -> GreyBox:
    """An undamped joint whose input changes at random at each sample: its acceleration is gain * u, held."""
    u = np.random.default_rng(5).normal(size=SAMPLES)
    seen = replace(ACCELEROMETER, values=values)
    driven = Driven("x", STEP_S, 0.0, "motor_current_command_a", u, True, (seen,), {})
    return GreyBox(driven, Split(np.array(edges_s), np.zeros(len(edges_s) - 1, bool)))


def _lagging(box: GreyBox) -> np.ndarray:
    """By hand: behind a lag, what is held for a sample is reached but for exp(-h / lag)."""
    shown, keep = np.zeros(SAMPLES), exp(-STEP_S / LAG_S)
    for k in range(SAMPLES - 1):
        shown[k + 1] = keep * shown[k] + (1.0 - keep) * 2.0 * box.driven.u[k]
    return shown


def _shown(box: GreyBox, **late: float) -> np.ndarray:
    numbers = NUMBERS | {f"{kind} {NAME}": value for kind, value in late.items()}
    return box.run(numbers, np.zeros((len(box.split.held), 2))).outputs[NAME]


def test_a_lag_shows_the_acceleration_as_it_was_before_it_jumped() -> None:
    exact = _lagging(_box(np.zeros(SAMPLES)))
    assert _shown(_box(exact), lag=LAG_S) == pytest.approx(exact, abs=1e-9)


def test_a_filter_goes_on_from_what_it_showed_where_a_block_begins() -> None:
    """A block may begin just after a jump, of which the block's own motion tells nothing."""
    exact = _lagging(_box(np.zeros(SAMPLES)))
    assert _shown(_box(exact, (0.0, 1.0, 2.5, STEP_S * SAMPLES)), lag=LAG_S) == pytest.approx(exact, abs=1e-9)


def test_a_slow_filter_of_a_velocity_still_shows_what_was_before_the_block() -> None:
    """A lag of five samples, of a motion that turns over within them."""
    name, numbers = "joint_velocity_rad_s", NUMBERS | {"lag joint_velocity_rad_s": 5.0 * STEP_S}
    whole = _box(np.zeros(SAMPLES))
    seen = Output(name, "velocity", np.zeros(SAMPLES), True, 0.0)
    whole = replace(whole, driven=replace(whole.driven, outputs=(seen,)))
    run = whole.run(numbers, np.zeros((1, 2)))
    exact = run.outputs[name]
    edges = np.array([0.0, 1.0, 2.5, STEP_S * SAMPLES])
    driven = replace(whole.driven, outputs=(replace(seen, values=exact),))
    parts = GreyBox(driven, Split(edges, np.zeros(3, bool)))
    shown = parts.run(numbers, np.ascontiguousarray(run.states[parts.starts[:-1]])).outputs[name]
    assert shown == pytest.approx(exact, abs=1e-9)


def test_a_delay_shows_what_was_between_two_jumps() -> None:
    box = _box(np.zeros(SAMPLES))
    shown = _shown(box, delay=0.5 * STEP_S)
    assert shown[1:] == pytest.approx(2.0 * box.driven.u[:-1], abs=1e-9)


def test_a_sensor_is_late_by_its_own_numbers_alone() -> None:
    assert is_late(ACCELEROMETER, {f"delay {NAME}": -0.01})
    assert is_late(ACCELEROMETER, {f"lag {NAME}": 0.01})
    assert not is_late(ACCELEROMETER, {f"lag {NAME}": 0.0, "delay joint_position_rad": 0.01})


def test_a_sensor_may_show_some_of_a_jump() -> None:
    """One that averages over a short time about its sample shows the mean of before and after."""
    box = _box(np.zeros(SAMPLES))
    u = box.driven.u
    assert _shown(box, jump=0.5)[1:] == pytest.approx(u[:-1] + u[1:], abs=1e-9)
    assert jump_shown(ACCELEROMETER, {}) == 1.0
    assert jump_shown(replace(ACCELEROMETER, kind="velocity"), {f"jump {NAME}": 0.5}) == 1.0
