"""The compiled simulation beside an integrator of its equations that was written apart from it."""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import pi

import numpy as np
import pytest
from numpy.typing import NDArray

from diagnosis.kernel import K, reads_later, run

Array = NDArray[np.float64]

DT, LENGTH, CYCLES = 0.001, 2.0, 2500
MODES = np.array([[2.6, 0.01, 1.3], [15.0, 0.02, -0.3]])
COMMAND: Array = np.zeros(CYCLES)
COMMAND[200:700] = np.linspace(0.0, 0.3, 500)
COMMAND[700:1300] = 0.3
COMMAND[1300:1800] = -0.2
COMMAND[1800:2300] = 0.01
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
    blows: dict[int, tuple[float, float]] = field(default_factory=dict)

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
            if k in self.blows:
                y[2] += self.blows[k][0]
                y[3] += self.blows[k][1]
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
    values: dict[str, float] | None = None, blows: dict[int, tuple[float, float]] | None = None
) -> tuple[Array, ...]:
    """theta, omega, alpha and motor theta of the kernel, its modes, q'', and alpha's jump; constants by name."""
    constants = np.zeros(K.SIZE)
    usual = {
        "LENGTH": LENGTH, "RATE": 2.0 * pi * 20.0, "DEAD_S": 0.0023, "MAX_VELOCITY": 1e9, "MAX_ACCELERATION": 1e3,
        "LOWEST": -10.0, "HIGHEST": 10.0, "ONSET_S": 1e9, "RATIO": 1.0, "HIGHER": 1.0,
    }  # fmt: skip
    for name, value in (usual | (values or {})).items():
        constants[K[name]] = value
    cycles = np.array([0, *sorted(blows or {})], dtype=np.int64)
    jumps = np.zeros((len(cycles), 2, 2))
    jumps[0] = np.array(START).reshape(2, 2)
    for row, cycle in enumerate(cycles[1:], start=1):
        jumps[row, 0] = (blows or {})[int(cycle)]
    joint, motor = np.empty((CYCLES, 4)), np.empty((CYCLES, 2))
    q, qdd = np.empty((CYCLES, 2)), np.empty((CYCLES, 2))
    run(COMMAND, np.empty(0), DT, 1, constants, MODES, cycles, jumps, joint, motor, q, qdd)
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
    found = simulated({"MAX_ACCELERATION": 2.0})
    assert off(found[0], theta) < 1e-6
    assert off(found[1], omega) < 1e-5
    assert off(found[4], q) < 1e-5


def test_a_limited_motion_changes_smoothly_with_the_bandwidth() -> None:
    """A likelihood with steps in it would name a bandwidth that is off by less than anything shows."""
    rates = 2.0 * pi * np.linspace(20.0, 24.0, 101)
    ends = np.array([simulated({"MAX_ACCELERATION": 2.0, "RATE": rate})[0] for rate in rates])
    turns = np.diff(ends, 2, axis=0)
    assert np.max(np.abs(turns)) < 0.02 * np.max(np.abs(np.diff(ends, axis=0)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("values", "obeys"),
    [
        ({"MAX_VELOCITY": 0.15}, lambda c: min(max(c, -0.15), 0.15)),
        ({"DEADBAND": 0.05}, lambda c: 0.0 if abs(c) <= 0.05 else c),
        ({"LOSS": 0.02}, lambda c: np.sign(c) * max(0.0, abs(c) - 0.02)),
    ],
)
def test_what_the_drive_makes_of_its_command(
    values: dict[str, float], obeys: Callable[[float], float]
) -> None:
    theta, _, q = Rig(obeys=obeys).integrate()
    found = simulated(values)
    assert off(found[0], theta) < 1e-6
    assert off(found[4], q) < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize(
    ("values", "force", "most"),
    [
        ({"CUBIC": 600.0}, lambda q, v, t: -((2 * pi * 2.6) ** 2) * 600.0 * q**3, 1e-3),
        ({"QUADRATIC": 10.0}, lambda q, v, t: -10.0 * v * abs(v), 2e-3),
        (
            {"PERIODIC_W": 2 * pi * 4.3, "PERIODIC_SIN": 0.4, "PERIODIC_COS": 0.3},
            lambda q, v, t: 0.4 * np.sin(2 * pi * 4.3 * t) + 0.3 * np.cos(2 * pi * 4.3 * t),
            3e-4,
        ),
        ({"COULOMB": 0.05}, lambda q, v, t: -0.05 * np.sign(v), 2e-3),
    ],
)
def test_forces_on_the_first_mode(
    values: dict[str, float], force: Callable[[float, float, float], float], most: float
) -> None:
    _, _, q = Rig(first_mode=force).integrate()
    plain = simulated()[4]
    found = simulated(values)[4]
    assert off(found[:, 0], q[:, 0]) < most
    assert off(plain[:, 0], q[:, 0]) > 30.0 * off(found[:, 0], q[:, 0])  # the force does something


def test_dry_friction_brings_the_arm_to_rest_and_holds_it() -> None:
    *_, q, qdd, _ = simulated({"COULOMB": 8.0})
    assert np.ptp(q[150:195, 0]) < 1e-3 * abs(q[0, 0])  # before the joint moves
    assert np.all(qdd[150:195, 0] == 0.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("values", "scale"),
    [
        ({"ONSET_S": 0.9, "RATIO": 0.9}, lambda t: 0.9 if t >= 0.9 - 1e-9 else 1.0),
        ({"DRIFT": -0.03}, lambda t: 1.0 - 0.03 * t),
    ],
)
@pytest.mark.parametrize("share", [1.0, 0.0, 1.5])
def test_frequencies_that_change(
    values: dict[str, float], scale: Callable[[float], float], share: float
) -> None:
    _, _, q = Rig(scale=scale, share=share).integrate()
    assert off(simulated(values | {"HIGHER": share})[4], q) < 1e-3
    assert off(simulated(values | {"HIGHER": share})[4][:, 1], q[:, 1]) < 5e-3


@pytest.mark.slow
def test_a_blow_adds_to_the_state_at_its_cycle() -> None:
    blows = {1500: (0.001, -0.4)}
    _, _, q = Rig(blows=blows).integrate()
    assert off(simulated(blows=blows)[4], q) < 1e-6


def test_play_stands_between_motor_and_joint() -> None:
    gap = 0.01
    theta, _, _, motor, *_ = simulated({"GAP": gap})
    wanted = np.empty(CYCLES)
    at = 0.0
    for k in range(CYCLES):
        at = min(max(at, motor[k] - 0.5 * gap), motor[k] + 0.5 * gap)
        wanted[k] = at
    assert np.max(np.abs(theta - wanted)) < 1e-12
    assert np.max(np.abs(theta - motor)) == pytest.approx(0.5 * gap)


@pytest.mark.parametrize("gap", [2e-4, 0.01])
def test_an_arm_behind_play_moves_as_in_steps_of_a_fiftieth(
    gap: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The link rests between the flanks, is struck within a cycle, and goes with the motor until that turns."""
    _, omega, _, _, q, qdd, _ = simulated({"GAP": gap})
    parts = 50
    monkeypatch.setattr("tests.diagnosis.test_kernel.DT", DT / parts)
    monkeypatch.setattr("tests.diagnosis.test_kernel.CYCLES", CYCLES * parts)
    monkeypatch.setattr("tests.diagnosis.test_kernel.COMMAND", np.repeat(COMMAND, parts))
    _, fine_omega, _, _, fine_q, fine_qdd, _ = simulated({"GAP": gap})
    assert off(omega, fine_omega[::parts]) < 1e-6
    for mode in range(2):
        assert off(q[:, mode], fine_q[::parts, mode]) < 1e-3
        assert off(qdd[:, mode], fine_qdd[::parts, mode]) < 1e-3


def test_next_to_no_play_is_none() -> None:
    """Or a play of nothing would explain what any lag of half a cycle does."""
    _, _, _, _, none, *_ = simulated()
    _, _, _, _, hardly_any, *_ = simulated({"GAP": 2e-10})
    assert off(hardly_any, none) < 1e-4


def test_the_joint_stops_at_the_end_of_its_range() -> None:
    theta, omega, *_ = simulated({"HIGHEST": 0.1})
    assert theta.max() == pytest.approx(0.1)
    assert np.all(omega[1200:1300] == 0.0)


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_acceleration_goes_on_evenly_where_the_dead_time_passes_a_cycle(share: float) -> None:
    """Read just before a command's arrival or just after it, the acceleration jumps; any share of the jump between."""

    def read(dead_cycles: float, share: float = share) -> Array:
        found = simulated({"DEAD_S": dead_cycles * DT, "MAX_ACCELERATION": 1e6})
        return found[2] + (share - reads_later(dead_cycles * DT, DT)) * found[6]

    least = 1e-2 * float(np.max(np.abs(read(3.0))))
    assert float(np.max(np.abs(read(3.0 + 1e-4) - read(3.0 - 1e-4)))) < least
    assert float(np.max(np.abs(read(3.0, 1.0) - read(3.0, 0.0)))) > 10.0 * least
    assert float(np.max(np.abs(read(3.0, 1.0) - read(3.0 - 1e-4, 1.0)))) < least  # whose command has come
    assert np.array_equal(read(3.5), read(3.5, 0.0))
