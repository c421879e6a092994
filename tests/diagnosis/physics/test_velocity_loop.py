"""A drive's velocity loop: a plain drive that obeys the equivalent command moves as theory says the other one does."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from stillarm.diagnosis.physics.velocity_loop import equivalent_command

Array = NDArray[np.float64]
DT, DECAY = 0.001, 2.0 * pi * 10.0
FAR = 1e9
PLAIN = {
    "begin_s": 0.0, "late_s": 0.0, "lag_s": 0.0, "friction": 0.0, "static": 0.0, "one_sided": 0.0, "most": FAR,
    "most_up": FAR, "most_down": FAR, "fastest_up": FAR, "fastest_down": FAR, "speeding_s": 0.0, "slowing_s": 0.0,
}  # fmt: skip
TIME = np.arange(4000) * DT
MOVES = np.where((TIME > 0.3) & (TIME < 1.2), 0.25, np.where((TIME > 1.8) & (TIME < 2.9), -0.15, 0.0))


def plain_drive(command: Array, omega: float = 0.0) -> Array:
    """Velocity after each cycle of a drive that follows its command, held over the cycle, with one lag."""
    stays, found = np.exp(-DECAY * DT), []
    for value in command:
        omega = value + (omega - value) * stays
        found.append(omega)
    return np.array(found)


def moved(command: Array, omega: float = 0.0, **more: float) -> Array:
    """Velocity after each cycle of a plain drive that obeys the equivalent command."""
    own = {**PLAIN, **more}
    return plain_drive(equivalent_command(command, DT, DECAY, omega, **own), omega)


@settings(deadline=None)
@given(st.lists(st.floats(-0.5, 0.5), min_size=2, max_size=50), st.floats(-0.5, 0.5))
def test_a_plain_drive_obeys_its_own_command(values: list[float], omega: float) -> None:
    command = np.array(values)
    found = equivalent_command(command, DT, DECAY, omega, **PLAIN)
    assert found == pytest.approx(command, abs=1e-9)


def test_friction_on_the_motion_is_taken_from_it_until_the_joint_rests() -> None:
    """omega' = d (c - omega - f sign(omega)), which ends at rest after ln((omega + f) / f) / d."""
    friction, start = 0.05, 0.3
    shown = moved(np.zeros(1000), start, friction=friction)
    time = (np.arange(1000) + 1.0) * DT
    stops = np.log((start + friction) / friction) / DECAY
    wanted = np.where(time < stops, (start + friction) * np.exp(-DECAY * time) - friction, 0.0)
    assert shown == pytest.approx(wanted, abs=1e-9)
    assert np.max(np.abs(shown[time > stops])) < 1e-15


def test_a_moving_joint_loses_the_friction_of_its_direction() -> None:
    up = moved(np.full(2000, 0.3), friction=0.05, one_sided=0.4)
    down = moved(np.full(2000, -0.3), friction=0.05, one_sided=0.4)
    assert up[-1] == pytest.approx(0.3 - 0.05 * 1.4)
    assert down[-1] == pytest.approx(-(0.3 - 0.05 * 0.6))


@settings(deadline=None)
@given(st.floats(0.02, 0.2), st.floats(-1.0, 1.0))
def test_a_resting_joint_stays_below_its_static_friction(static: float, share: float) -> None:
    shown = moved(np.full(500, share * static), friction=0.5 * static, static=static)
    assert np.all(shown == 0.0)
    freed = moved(np.full(500, 1.01 * static), friction=0.5 * static, static=static)
    assert freed[-1] == pytest.approx(0.51 * static)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_joint_that_speeds_up_may_lag_more_than_one_that_slows_down(way: float) -> None:
    """From rest to 0.3 rad/s and back: each with the lag of its own."""
    command = way * np.where(np.arange(1000) < 500, 0.3, 0.0)
    time = (np.arange(500) + 1.0) * DT
    for speeding, slowing in ((0.02, 0.0), (0.0, 0.02)):
        shown = moved(command, speeding_s=speeding, slowing_s=slowing)
        up, down = (1.0 / (1.0 / DECAY + more) for more in (speeding, slowing))
        assert shown[:500] == pytest.approx(way * 0.3 * (1.0 - np.exp(-up * time)), abs=1e-9)
        assert shown[500:] == pytest.approx(shown[499] * np.exp(-down * time), abs=1e-9)


@pytest.mark.slow
def test_a_further_lag_is_a_filter_in_front_of_the_drive() -> None:
    """Steps through two lags in a row, by an integrator."""
    lag_s = 0.03

    def both(t: float, y: Array) -> list[float]:
        command = MOVES[min(int(t / DT + 1e-9), len(MOVES) - 1)]
        return [(command - y[0]) / lag_s, DECAY * (y[0] - y[1])]

    solved = solve_ivp(both, (0.0, TIME[-1] + DT), [0.0, 0.0], t_eval=TIME + DT, max_step=DT, rtol=1e-8)
    shown = moved(MOVES, lag_s=lag_s)
    assert (
        np.max(np.abs(shown - solved.y[1])) < 0.25 * DT / lag_s
    )  # half a cycle's hold of a step of a quarter


@pytest.mark.slow
@settings(deadline=None, max_examples=20)
@given(st.integers(0, 40))
def test_a_dead_time_of_whole_cycles_shifts_what_the_joint_does(cycles: int) -> None:
    shown, now = moved(MOVES, late_s=cycles * DT), moved(MOVES)
    assert shown[cycles:] == pytest.approx(now[: len(now) - cycles], abs=1e-9)


def test_a_dead_time_of_half_a_cycle_is_the_mean_of_both() -> None:
    between = 0.5 * (moved(MOVES, late_s=0.004) + moved(MOVES, late_s=0.005))
    assert moved(MOVES, late_s=0.0045) == pytest.approx(between, abs=1e-9)


def test_limits_of_acceleration_hold_both_ways_and_one_way() -> None:
    gains = np.diff(moved(MOVES, most=2.0))
    assert np.max(gains) == pytest.approx(2.0 * DT) and np.min(gains) == pytest.approx(-2.0 * DT)
    gains = np.diff(moved(MOVES, most_up=1.5))
    free = np.diff(moved(MOVES))
    assert np.max(gains) == pytest.approx(1.5 * DT) and np.min(gains) < 0.5 * np.min(free)
    gains = np.diff(moved(MOVES, most_down=1.5))
    assert np.min(gains) == pytest.approx(-1.5 * DT) and np.max(gains) == pytest.approx(np.max(free))


def test_limits_of_velocity_hold_each_way() -> None:
    shown = moved(MOVES, fastest_up=0.2, fastest_down=0.1)
    assert np.max(shown) == pytest.approx(0.2) and np.min(shown) == pytest.approx(-0.1)
    assert np.all(np.abs(moved(MOVES, fastest_up=0.2, fastest_down=0.2)) <= 0.2 + 1e-12)


@pytest.mark.parametrize(
    "more", [{"friction": 0.05, "static": 0.1}, {"most": 1.0}, {"lag_s": 0.02}, {"late_s": 0.02}, {"fastest_up": 0.1}]
)  # fmt: skip
def test_nothing_acts_before_it_begins(more: dict[str, float]) -> None:
    begins = round(1.0 / DT)
    found = equivalent_command(MOVES, DT, DECAY, 0.0, **{**PLAIN, **more, "begin_s": 1.0})
    assert found[:begins] == pytest.approx(MOVES[:begins], abs=1e-12)
    assert np.max(np.abs(found[begins:] - MOVES[begins:])) > 0.01
