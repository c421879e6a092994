"""The arm's causes against scipy and against closed forms."""

from collections.abc import Callable
from math import exp, pi, sin
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from stillarm.common.files.model import Arm, Drive, Mode, Model
from stillarm.common.user_error import UserError
from stillarm.simulation.arm.plant import Plant
from tests.reference.effects_judge import TOLERANCES, ringing

Array = NDArray[np.float64]
CYCLE_S = 0.001
W = 2.0 * pi * 2.6


def arm(*effects: dict[str, Any], modes: list[Mode] | None = None) -> Plant:
    modes = modes or [Mode(frequency_hz=2.6, damping_ratio=0.01, participation=1.14)]
    return Plant(
        Model(arm=Arm(length_m=2.0, modes=modes), drive=Drive(dead_time_s=0.0), effects=list(effects))
    )


def rings(plant: Plant, amplitude_m: float, cycles: int) -> tuple[Array, Array]:
    """Times and deflections after a blow at 0."""
    plant.strike(1, amplitude_m)
    deflections = [plant.deflection_m]
    for _ in range(cycles):
        plant.advance(0.0)
        deflections.append(plant.deflection_m)
    return np.arange(cycles + 1) * CYCLE_S, np.array(deflections)


Force = Callable[[float, float, float, float], float]
FORCES: list[tuple[dict[str, Any], Force]] = [
    (
        {"cause": "cubic_stiffness", "coefficient_per_m2": 900.0},
        lambda t, w, q, v: -w * w * 900.0 * q**3,
    ),
    (
        {"cause": "cubic_stiffness", "coefficient_per_m2": -600.0},
        lambda t, w, q, v: w * w * 600.0 * q**3,
    ),
    ({"cause": "quadratic_damping", "coefficient_per_m": 8.0}, lambda t, w, q, v: -8.0 * v * abs(v)),
    (
        {"cause": "periodic_disturbance", "frequency_hz": 4.1, "amplitude_m_s2": 0.9, "phase_rad": 0.7},
        lambda t, w, q, v: 0.9 * sin(2.0 * pi * 4.1 * t + 0.7),
    ),
]


@pytest.mark.slow
@pytest.mark.parametrize(("effect", "force"), FORCES)
def test_forces_are_those_of_the_catalogue(effect: dict[str, Any], force: Force) -> None:
    """Within 1e-4 of the amplitude over four seconds; without the effect it would be off by a fifth or more."""
    times, found = rings(arm(effect), 0.02, 4000)
    wanted = ringing(0.02, times, force=force)
    assert np.max(np.abs(found - wanted)) < 1e-4 * 0.02
    assert np.max(np.abs(ringing(0.02, times) - wanted)) > 0.2 * 0.02


def test_two_forces_at_once_are_still_of_second_order() -> None:
    """Their kicks mirror each other across the cycle; in one order both times, the error would be 17 times larger."""
    effects, forces = zip(FORCES[0], FORCES[2], strict=True)
    times, found = rings(arm(*effects), 0.02, 250)
    wanted = ringing(0.02, times, force=lambda *state: sum(force(*state) for force in forces))
    assert np.max(np.abs(found - wanted)) < 1e-5 * 0.02


def test_cubic_stiffness_has_the_known_backbone_curve() -> None:
    """Duffing without damping: w / w1 = 1 + 3 c A^2 / 8 - 21 (c A^2)^2 / 256 + ... (Nayfeh and Mook)."""
    for amplitude in (0.005, 0.015, 0.025):
        plant = arm(
            {"cause": "cubic_stiffness", "coefficient_per_m2": 200.0},
            modes=[Mode(frequency_hz=2.6, damping_ratio=0.0)],
        )
        times, found = rings(plant, amplitude, 8000)
        greatest = float(np.max(found))
        up = np.flatnonzero((found[:-1] < 0.0) & (found[1:] >= 0.0))
        crossings = times[up] - found[up] * CYCLE_S / (found[up + 1] - found[up])
        period = float(np.mean(np.diff(crossings)))
        e = 200.0 * greatest**2
        assert 1.0 / period / 2.6 == pytest.approx(1.0 + 3.0 * e / 8.0 - 21.0 * e * e / 256.0, rel=1e-4)


def test_a_softening_arm_that_no_longer_returns_is_refused_in_one_line() -> None:
    plant = arm({"cause": "cubic_stiffness", "coefficient_per_m2": -2000.0})
    with pytest.raises(UserError, match=r"^effects: cubic_stiffness: coefficient_per_m2 = -2000: [^\n]+$"):
        rings(plant, 0.05, 1000)


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
    effects = [dict(effect) for effect, _ in (FORCES[0], FORCES[2])]
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


@pytest.mark.parametrize("share", [None, 0.0, 1.4])
def test_a_payload_changes_every_frequency_by_its_share_from_its_onset_on(share: float | None) -> None:
    """All alike where nothing else is said."""
    effect = {"cause": "payload_change", "onset_s": 1.5, "frequency_ratio": 0.9}
    effect |= {} if share is None else {"higher_modes_share": share}
    hz = 16.0 * (1.0 - 0.1 * (1.0 if share is None else share))
    times, found = rings(arm(effect), 0.006, 4000)
    wanted = ringing(0.006, times, frequency_hz=lambda t: 2.6 if t < 1.5 else 2.34, breaks_s=(1.5,))
    assert np.max(np.abs(found - wanted)) < 1e-8
    modes = [Mode(frequency_hz=2.6), Mode(frequency_hz=16.0, damping_ratio=0.0, participation=-0.14)]
    plant = arm(effect, modes=modes)
    for _ in range(2000):
        plant.advance(0.0)
    plant.strike(2, 0.001)
    second = []
    for _ in range(500):
        plant.advance(0.0)
        second.append(plant.modal_deflections_m[1])
    t = np.arange(1, 501) * CYCLE_S
    assert np.max(np.abs(second - 0.001 * np.sin(2.0 * pi * hz * t))) < 1e-9


def test_a_drifting_stiffness_moves_the_frequency_evenly() -> None:
    effect = {"cause": "stiffness_drift", "frequency_rate_hz_per_s": 0.05}
    times, found = rings(arm(effect), 0.006, 6000)
    wanted = ringing(0.006, times, frequency_hz=lambda t: 2.6 + 0.05 * t)
    assert np.max(np.abs(found - wanted)) < 1e-4 * 0.006
    down = arm({"cause": "stiffness_drift", "frequency_rate_hz_per_s": -2.0})
    with pytest.raises(UserError, match=r"^effects: stiffness_drift: at 1\.\d+ s [^\n]+$"):
        rings(down, 0.001, 2000)


def test_a_second_bending_mode_is_one_of_the_arms() -> None:
    """The same numbers as with the mode in [[arm.modes]]."""
    second = {"frequency_hz": 15.0, "damping_ratio": 0.02, "participation": -0.2}
    first = Mode()
    named, listed = arm({"cause": "second_bending_mode", **second}), arm(modes=[first, Mode(**second)])
    for command in np.random.default_rng(0).uniform(-0.3, 0.3, 300).tolist():
        named.advance(command)
        listed.advance(command)
    assert named.modal_deflections_m == listed.modal_deflections_m
    assert named.tip_acceleration_m_s2 == listed.tip_acceleration_m_s2
