"""The compiled simulation beside an integrator of its equations that was written apart from it."""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import atan2, hypot, pi
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from stillarm.common.files.model import Drive
from stillarm.simulation.arm.compiled_laws import laws_of, obeyed
from stillarm.simulation.arm.free_run import driven_run, free_run, reads_later
from stillarm.simulation.arm.state import make_arm

Array = NDArray[np.float64]

DT, LENGTH, CYCLES = 0.001, 2.0, 2500
MODES = np.array([[2.6, 0.01, 1.3], [15.0, 0.02, -0.3]])
COMMAND: Array = np.zeros(CYCLES)
COMMAND[200:700] = np.linspace(0.0, 0.3, 500)
COMMAND[700:1300] = 0.3
COMMAND[1300:1800] = -0.2
COMMAND[1800:2300] = 0.01
DRIVE = Drive(
    dead_time_s=0.0023,
    max_velocity_rad_s=1e9,
    max_acceleration_rad_s2=1e3,
    min_position_rad=-10.0,
    max_position_rad=10.0,
)
PARTS = 50
USUAL = {"higher_modes_share": 1.0}
START = (0.02, 0.3, 0.001, 0.0)  # q_1, q_1', q_2, q_2'


@dataclass
class Rig:
    """The equations of docs/causes.md in continuous time."""

    bandwidth_hz: float = 20.0
    dead_s: float = 0.0023
    most_rad_s2: float = 1e3
    obeys: Callable[[float], float] = lambda c: c
    first_mode: Callable[[float, float, float], float] = lambda q, v, t: 0.0
    scale: Callable[[float], float] = lambda t: 1.0
    share: float = 1.0
    impacts: dict[int, tuple[float, float]] = field(default_factory=dict)

    def rates(self, y: Array, t: float, target: float) -> Array:
        """d/dt of theta, omega, q_1, q_1', q_2, q_2'."""
        lag = 2.0 * pi * self.bandwidth_hz
        alpha = min(max(lag * (target - y[1]), -self.most_rad_s2), self.most_rad_s2)
        out = np.empty(6)
        out[0], out[1] = y[1], alpha
        for i, (f, zeta, participation) in enumerate(MODES):
            w = 2.0 * pi * f * (1.0 + (self.share if i else 1.0) * (self.scale(t) - 1.0))
            q, v = y[2 + 2 * i], y[3 + 2 * i]
            out[2 + 2 * i] = v
            out[3 + 2 * i] = -2.0 * zeta * w * v - w * w * q - participation * LENGTH * alpha
        out[3] += self.first_mode(y[2], y[3], t)
        return out

    def integrate(self) -> tuple[Array, Array, Array]:
        """Runge and Kutta's fourth order, eight steps a cycle, broken where the delayed command changes."""
        y = np.array([0.0, 0.0, *START])
        theta, omega, q = np.empty(CYCLES), np.empty(CYCLES), np.empty((CYCLES, 2))
        whole, rest = int(self.dead_s / DT), self.dead_s % DT
        for k in range(CYCLES):
            if k in self.impacts:
                y[2] += self.impacts[k][0]
                y[3] += self.impacts[k][1]
            theta[k], omega[k], q[k] = y[0], y[1], y[2::2]
            for start, span, index in ((0.0, rest, k - whole - 1), (rest, DT - rest, k - whole)):
                target = self.obeys(COMMAND[max(index, 0)])
                h = span / 4
                for part in range(4):
                    t = k * DT + start + part * h
                    a = self.rates(y, t, target)
                    b = self.rates(y + 0.5 * h * a, t + 0.5 * h, target)
                    c = self.rates(y + 0.5 * h * b, t + 0.5 * h, target)
                    d = self.rates(y + h * c, t + h, target)
                    y = y + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        return theta, omega, q


def simulated(
    *effects: dict[str, Any],
    drive: Drive = DRIVE,
    gap: float = 0.0,
    impacts: dict[int, tuple[float, float]] | None = None,
) -> tuple[Array, ...]:
    """theta, omega, alpha and motor theta of the free run, its modes, q'', and alpha's jump."""
    named = [(one["cause"], USUAL | one) for one in effects]
    arm, whole = make_arm(drive, DT, MODES * (1.0, 1.0, LENGTH), laws_of(named), gap, turn_rad=0.03)
    cycles = np.array([0, *sorted(impacts or {})], dtype=np.int64)
    jumps = np.zeros((len(cycles), 2, 2))
    jumps[0] = np.array(START).reshape(2, 2)
    for row, cycle in enumerate(cycles[1:], start=1):
        jumps[row, 0] = (impacts or {})[int(cycle)]
    joint, motor = np.empty((CYCLES, 4)), np.empty((CYCLES, 2))
    q, qdd = np.empty((CYCLES, 2)), np.empty((CYCLES, 2))
    limit = drive.max_velocity_rad_s
    command = obeyed(named, np.clip(COMMAND, -limit, limit))
    free_run(arm, command, whole, cycles, jumps, joint, motor, q, qdd)
    return joint[:, 0], joint[:, 1], joint[:, 2], motor[:, 0], q, qdd, joint[:, 3]


def off(found: Array, wanted: Array) -> float:
    """Largest difference, as a part of the largest value."""
    return float(np.max(np.abs(found - wanted)) / np.max(np.abs(wanted)))


@pytest.mark.slow
def test_the_linear_rig_with_two_modes_and_a_dead_time_of_no_whole_cycles() -> None:
    theta, omega, q = Rig().integrate()
    found = simulated()
    assert off(found[0], theta) < 1e-6
    assert off(found[1], omega) < 1e-6
    assert off(found[4], q) < 1e-6


def test_accelerations_are_those_of_the_motion() -> None:
    *_, q, qdd, _ = simulated()
    twice = (q[2:] - 2.0 * q[1:-1] + q[:-2]) / DT**2
    smooth = slice(50, 190)  # no step of the command in it
    assert off(twice[smooth], qdd[1:-1][smooth]) < 2e-3


@pytest.mark.slow
def test_acceleration_of_the_joint_is_limited() -> None:
    """The limit ends within a cycle: were it to end with one, the velocity would be off by up to a cycle of it."""
    theta, omega, q = Rig(most_rad_s2=2.0).integrate()
    found = simulated(drive=replace(DRIVE, max_acceleration_rad_s2=2.0))
    assert off(found[0], theta) < 1e-6
    assert off(found[1], omega) < 1e-5
    assert off(found[4], q) < 1e-5


def test_a_limited_motion_changes_smoothly_with_the_bandwidth() -> None:
    """A likelihood with steps in it would name a bandwidth that is off by less than anything shows."""
    drives = [
        replace(DRIVE, max_acceleration_rad_s2=2.0, bandwidth_hz=hz) for hz in np.linspace(20.0, 24.0, 101)
    ]
    ends = np.array([simulated(drive=drive)[0] for drive in drives])
    turns = np.diff(ends, 2, axis=0)
    assert np.max(np.abs(turns)) < 0.02 * np.max(np.abs(np.diff(ends, axis=0)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "obeys"),
    [
        ({"cause": "drive_deadband", "deadband_rad_s": 0.05}, lambda c: 0.0 if abs(c) <= 0.05 else c),
        (
            {"cause": "joint_friction", "velocity_loss_rad_s": 0.02},
            lambda c: np.sign(c) * max(0.0, abs(c) - 0.02),
        ),
    ],
)
def test_what_the_drive_makes_of_its_command(effect: dict[str, Any], obeys: Callable[[float], float]) -> None:
    theta, _, q = Rig(obeys=obeys).integrate()
    found = simulated(effect)
    assert off(found[0], theta) < 1e-6
    assert off(found[4], q) < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "force", "most"),
    [
        (
            {"cause": "cubic_stiffness", "coefficient_per_m2": 600.0},
            lambda q, v, t: -((2 * pi * 2.6) ** 2) * 600.0 * q**3,
            1e-6,
        ),
        ({"cause": "quadratic_damping", "coefficient_per_m": 10.0}, lambda q, v, t: -10.0 * v * abs(v), 1e-6),
        (
            {
                "cause": "periodic_disturbance",
                "frequency_hz": 4.3,
                "amplitude_m_s2": hypot(0.4, 0.3),
                "phase_rad": atan2(0.3, 0.4),
            },
            lambda q, v, t: 0.4 * np.sin(2 * pi * 4.3 * t) + 0.3 * np.cos(2 * pi * 4.3 * t),
            1e-6,
        ),
        # the judge's own steps straddle the reversals
        ({"cause": "coulomb_damping", "force_per_mass_m_s2": 0.05}, lambda q, v, t: -0.05 * np.sign(v), 1e-4),
    ],
)
def test_forces_on_the_first_mode(
    effect: dict[str, Any], force: Callable[[float, float, float], float], most: float
) -> None:
    _, _, q = Rig(first_mode=force).integrate()
    plain = simulated()[4]
    found = simulated(effect)[4]
    assert off(found[:, 0], q[:, 0]) < most
    assert off(plain[:, 0], q[:, 0]) > 30.0 * off(found[:, 0], q[:, 0])  # the force does something


def test_dry_friction_brings_the_arm_to_rest_and_holds_it() -> None:
    *_, q, qdd, _ = simulated({"cause": "coulomb_damping", "force_per_mass_m_s2": 8.0})
    assert np.ptp(q[150:195, 0]) < 1e-3 * abs(q[0, 0])  # before the joint moves
    assert np.all(qdd[150:195, 0] == 0.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "scale"),
    [
        (
            {"cause": "payload_change", "onset_s": 0.9, "frequency_ratio": 0.9},
            lambda t: 0.9 if t >= 0.9 - 1e-9 else 1.0,
        ),
        ({"cause": "stiffness_drift", "frequency_rate_hz_per_s": -0.03 * 2.6}, lambda t: 1.0 - 0.03 * t),
    ],
)
@pytest.mark.parametrize("share", [1.0, 0.0, 1.5])
def test_frequencies_that_change(
    effect: dict[str, Any], scale: Callable[[float], float], share: float
) -> None:
    _, _, q = Rig(scale=scale, share=share).integrate()
    found = simulated(effect | {"higher_modes_share": share})[4]
    assert off(found, q) < 1e-3
    assert off(found[:, 1], q[:, 1]) < 5e-3


@pytest.mark.slow
def test_an_impact_adds_to_the_state_at_its_cycle() -> None:
    impacts = {1500: (0.001, -0.4)}
    _, _, q = Rig(impacts=impacts).integrate()
    assert off(simulated(impacts=impacts)[4], q) < 1e-6


def fiftieths(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cycles of a fiftieth from now on, under the same command."""
    module = "tests.simulation.arm.test_free_run"
    monkeypatch.setattr(f"{module}.DT", DT / PARTS)
    monkeypatch.setattr(f"{module}.CYCLES", CYCLES * PARTS)
    monkeypatch.setattr(f"{module}.COMMAND", np.repeat(COMMAND, PARTS))


def test_play_stands_between_motor_and_joint(monkeypatch: pytest.MonkeyPatch) -> None:
    """As the play operator has it of the motor's motion in steps of a fiftieth, which sees where that turns."""
    gap = 0.01
    theta, _, _, coarse, *_ = simulated(gap=gap)
    fiftieths(monkeypatch)
    motor = simulated()[3]
    wanted = np.empty(len(motor))
    at = 0.0
    for k, angle in enumerate(motor):
        at = min(max(at, angle - 0.5 * gap), angle + 0.5 * gap)
        wanted[k] = at
    assert np.max(np.abs(theta - wanted[::PARTS])) < 1e-8
    assert np.max(np.abs(theta - coarse)) == pytest.approx(0.5 * gap)


@pytest.mark.parametrize("gap", [2e-4, 0.01])
def test_an_arm_behind_play_moves_as_in_steps_of_a_fiftieth(
    gap: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The link rests between the flanks, is struck within a cycle, and goes with the motor until that turns."""
    _, omega, _, _, q, qdd, _ = simulated(gap=gap)
    fiftieths(monkeypatch)
    _, fine_omega, _, _, fine_q, fine_qdd, _ = simulated(gap=gap)
    assert off(omega, fine_omega[::PARTS]) < 1e-8
    for mode in range(2):
        assert off(q[:, mode], fine_q[::PARTS, mode]) < 1e-8
        assert off(qdd[:, mode], fine_qdd[::PARTS, mode]) < 1e-8


def test_next_to_no_play_is_none() -> None:
    """Or a play of nothing would explain what any lag of half a cycle does."""
    _, _, _, _, none, *_ = simulated()
    _, _, _, _, hardly_any, *_ = simulated(gap=2e-10)
    assert off(hardly_any, none) < 1e-6


def test_the_joint_stops_at_the_end_of_its_range() -> None:
    theta, omega, *_ = simulated(drive=replace(DRIVE, max_position_rad=0.1))
    assert theta.max() == pytest.approx(0.1)
    assert np.all(omega[1200:1300] == 0.0)


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_acceleration_goes_on_evenly_where_the_dead_time_passes_a_cycle(share: float) -> None:
    """Read just before a command's arrival or just after it, the acceleration jumps; any share of the jump between."""

    def read(dead_cycles: float, share: float = share) -> Array:
        found = simulated(drive=replace(DRIVE, dead_time_s=dead_cycles * DT, max_acceleration_rad_s2=1e6))
        return found[2] + (share - reads_later(dead_cycles * DT, DT)) * found[6]

    least = 1e-2 * float(np.max(np.abs(read(3.0))))
    assert float(np.max(np.abs(read(3.0 + 1e-4) - read(3.0 - 1e-4)))) < least
    assert float(np.max(np.abs(read(3.0, 1.0) - read(3.0, 0.0)))) > 10.0 * least
    assert float(np.max(np.abs(read(3.0, 1.0) - read(3.0 - 1e-4, 1.0)))) < least  # whose command has come
    assert np.array_equal(read(3.5), read(3.5, 0.0))


@pytest.mark.slow
def test_a_driven_oscillator_follows_a_force_between_its_samples() -> None:
    """A Duffing oscillator with seventeen samples a period, the force as it is halfway between them known."""
    w, zeta, cubic, gain, per_sample = 2.0 * pi * 70.0, 0.05, 400.0, 300.0, 4
    dt, n = 1.0 / 1200.0, 600

    def force(t: float | Array) -> float | Array:
        return gain * (np.sin(2.0 * pi * 55.0 * t) + 0.6 * np.sin(2.0 * pi * 83.0 * t + 1.0))

    def slope(t: float, x: Array) -> list[float]:
        return [x[1], float(force(t)) - 2.0 * zeta * w * x[1] - w * w * (x[0] + cubic * x[0] ** 3)]

    wanted = solve_ivp(slope, (0.0, n * dt), [0.0, 0.0], t_eval=np.arange(n) * dt, rtol=1e-10, atol=1e-13)
    law = laws_of([("cubic_stiffness", {"coefficient_per_m2": cubic})])
    arm, _ = make_arm(DRIVE, dt, np.array([[70.0, zeta, 0.0]]), law, turn_rad=0.25)
    q, qdd = np.empty((n, 1)), np.empty((n, 1))
    fine = np.asarray(force(np.arange(per_sample * n + 1) * dt / per_sample))
    driven_run(arm, fine, dt, per_sample // 2, np.zeros(1, np.int64), np.zeros((1, 1, 2)), q, qdd)
    assert np.max(np.abs(q[:, 0])) ** 2 * cubic > 0.01  # it bends so far that the cubic part counts
    assert off(q[:, 0], wanted.y[0]) < 2e-4
