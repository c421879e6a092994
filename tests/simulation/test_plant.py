"""The plant against an independent solution of its equations by scipy at rtol 1e-10."""

from itertools import pairwise
from math import cos, cosh, pi, sin, sinh, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from common.beam import tip_slopes_per_m
from common.model import Arm, Drive, Mode, Model
from common.scenario import Scenario, Strike
from common.user_error import UserError
from simulation.disturbance import Disturbance
from simulation.plant import Plant
from simulation.plant_effects import unsupported_effects

CYCLE_S = 0.001
LENGTH_M = 2.0
FIRST = Mode(frequency_hz=2.6, damping_ratio=0.01, participation=1.14)
SECOND = Mode(frequency_hz=16.3, damping_ratio=0.02, participation=-0.14)
FAST = Mode(frequency_hz=400.0, damping_ratio=0.005, participation=0.3)
QUICK_DRIVE = Drive(max_velocity_rad_s=10.0, max_acceleration_rad_s2=1e4)

Array = NDArray[np.float64]


def model(modes: list[Mode], drive: Drive = QUICK_DRIVE) -> Model:
    return Model(arm=Arm(length_m=LENGTH_M, modes=modes), drive=drive)


def run(plant: Plant, commands: Array) -> Array:
    """Rows of (theta, theta', q_1, q_1', ...) at the beginning and after each cycle."""
    rows = []
    for command in [None, *commands.tolist()]:
        if command is not None:
            plant.advance(command)
        rows.append([plant.joint_position_rad, plant.joint_velocity_rad_s])
        for deflection, rate in zip(plant.modal_deflections_m, plant.modal_rates_m_s, strict=True):
            rows[-1] += [deflection, rate]
    return np.array(rows)


def solved(of: Model, commands: Array, start: Array, extra: float = 0.0) -> Array:
    """The same by solve_ivp, written from the contract's equations; restarted wherever the command changes.

    extra: coefficient of a cubic stiffness, w^2 (q + c q^3), on the first mode.
    """
    drive = of.drive
    lag = 2.0 * pi * drive.bandwidth_hz

    def command_at(time: float) -> float:
        index = int(np.floor((time - drive.dead_time_s) / CYCLE_S + 1e-6))
        held = commands[index] if index >= 0 else 0.0
        return float(np.clip(held, -drive.max_velocity_rad_s, drive.max_velocity_rad_s))

    def slope(time: float, state: Array, held: float) -> list[float]:
        joint = lag * (held - state[1])
        joint = min(max(joint, -drive.max_acceleration_rad_s2), drive.max_acceleration_rad_s2)
        out = [state[1], joint]
        for number, mode in enumerate(of.arm.modes):
            w = 2.0 * pi * mode.frequency_hz
            q, rate = state[2 + 2 * number], state[3 + 2 * number]
            bend = -w * w * q - 2.0 * mode.damping_ratio * w * rate - mode.participation * LENGTH_M * joint
            out += [rate, bend - (extra * w * w * q**3 if number == 0 else 0.0)]
        return out

    end = len(commands) * CYCLE_S
    phase = drive.dead_time_s % CYCLE_S
    grid = np.arange(len(commands) + 1) * CYCLE_S
    edges = np.unique(np.round(np.concatenate([grid, grid[:-1] + phase]), 12))
    state, states = np.array(start, dtype=float), [np.array(start, dtype=float)]
    for begin, finish in pairwise(edges):
        held = command_at(0.5 * (begin + finish))
        solution = solve_ivp(
            slope, (begin, finish), state, args=(held,), rtol=1e-10, atol=1e-13, method="DOP853"
        )
        state = solution.y[:, -1]
        if np.min(np.abs(grid - finish)) < 1e-9:
            states.append(state)
    assert abs(edges[-1] - end) < 1e-9
    return np.array(states)


def assert_same(ours: Array, judge: Array, fraction: float = 1e-7) -> None:
    """Equal to a fraction of each column's range."""
    assert ours.shape == judge.shape
    assert np.all(np.max(np.abs(ours - judge), axis=0) <= fraction * (np.ptp(judge, axis=0) + 1e-9))


def moves(cycles: int, amplitude: float, seed: int = 1) -> Array:
    """A command that changes in steps, some of them each cycle."""
    generator = np.random.default_rng(seed)
    slow = np.repeat(generator.uniform(-amplitude, amplitude, cycles // 40 + 1), 40)[:cycles]
    return slow + 0.05 * amplitude * generator.standard_normal(cycles)


@pytest.mark.parametrize("modes", [[FIRST], [FIRST, SECOND], [FIRST, FAST]])
def test_ring_down(modes: list[Mode]) -> None:
    of = model(modes)
    plant = Plant(of)
    for number in range(1, len(modes) + 1):
        plant.strike(number, 0.006 / number)
    start = np.array(
        [0.0, 0.0] + [v for n, m in enumerate(modes, 1) for v in (0.0, 2 * pi * m.frequency_hz * 0.006 / n)]
    )
    commands = np.zeros(300)
    assert_same(run(plant, commands), solved(of, commands, start))


@pytest.mark.parametrize("dead_time_s", [0.0, 0.0004, 0.001, 0.002, 0.0025, 0.0179])
def test_dead_time_of_any_length(dead_time_s: float) -> None:
    of = model(
        [FIRST, SECOND], Drive(dead_time_s=dead_time_s, max_velocity_rad_s=10.0, max_acceleration_rad_s2=1e4)
    )
    commands = moves(160, 0.4)
    assert_same(run(Plant(of), commands), solved(of, commands, np.zeros(6)))


def test_two_and_a_half_cycles_of_dead_time_are_exactly_that() -> None:
    of = model([FIRST], Drive(dead_time_s=0.0025))
    plant = Plant(of)
    velocities = run(plant, np.full(4, 0.1))[:, 1]
    assert np.all(velocities[:3] == 0.0)
    lag = 2.0 * pi * 20.0
    assert velocities[3] == pytest.approx(0.1 * (1.0 - np.exp(-lag * 0.0005)), rel=1e-12)
    assert velocities[4] == pytest.approx(0.1 * (1.0 - np.exp(-lag * 0.0015)), rel=1e-12)


@pytest.mark.parametrize("bandwidth_hz", [5.0, 20.0, 300.0])
def test_moves_with_velocity_and_acceleration_limits(bandwidth_hz: float) -> None:
    drive = Drive(
        bandwidth_hz=bandwidth_hz, dead_time_s=0.0015, max_velocity_rad_s=0.3, max_acceleration_rad_s2=8.0
    )
    of = model([FIRST, SECOND], drive)
    commands = moves(400, 0.8)
    ours = run(Plant(of), commands)
    assert_same(
        ours, solved(of, commands, np.zeros(6)), 2e-6
    )  # the judge itself smears the corner of the limit
    steps = np.abs(np.diff(ours[:, 1]))
    assert np.max(steps) == pytest.approx(8.0 * CYCLE_S, rel=1e-9)
    assert np.max(np.abs(ours[:, 1])) <= 0.3


def test_many_fast_modes_under_a_moving_joint() -> None:
    modes = [
        Mode(frequency_hz=f, damping_ratio=0.01, participation=0.2)
        for f in (2.6, 16.0, 46.0, 90.0, 150.0, 400.0)
    ]
    of = model(modes)
    commands = moves(120, 0.4)
    assert_same(run(Plant(of), commands), solved(of, commands, np.zeros(14)))


def test_accelerations_and_tip_are_those_of_the_equations() -> None:
    plant = Plant(model([FIRST, SECOND], Drive(dead_time_s=0.0)))
    plant.strike(2, 0.001)
    plant.modal_forces_m_s2 = [0.3, -0.2]
    for command in moves(50, 0.4).tolist():
        plant.advance(command)
    joint = 2.0 * pi * 20.0 * (command - plant.joint_velocity_rad_s)
    assert plant.joint_acceleration_rad_s2 == pytest.approx(joint, rel=1e-9)
    tip = LENGTH_M * joint
    for mode, q, rate, force in zip(
        (FIRST, SECOND), plant.modal_deflections_m, plant.modal_rates_m_s, (0.3, -0.2), strict=True
    ):
        w = 2.0 * pi * mode.frequency_hz
        tip += force - mode.participation * LENGTH_M * joint - 2.0 * mode.damping_ratio * w * rate - w * w * q
    assert plant.tip_acceleration_m_s2 == pytest.approx(tip, rel=1e-9)
    assert plant.deflection_m == pytest.approx(sum(plant.modal_deflections_m), rel=1e-12)
    assert plant.tip_position_m == pytest.approx(
        LENGTH_M * plant.joint_position_rad + plant.deflection_m, rel=1e-12
    )
    slopes = tip_slopes_per_m(LENGTH_M, 2)
    bent = sum(s * q for s, q in zip(slopes, plant.modal_deflections_m, strict=True))
    assert plant.tip_angle_rad == pytest.approx(plant.joint_position_rad + bent, rel=1e-12)


def test_a_constant_force_bends_the_arm_by_force_over_stiffness() -> None:
    plant = Plant(model([Mode(frequency_hz=10.0, damping_ratio=0.5)]))
    plant.modal_forces_m_s2 = [2.0]
    run(plant, np.zeros(1500))
    assert plant.deflection_m == pytest.approx(2.0 / (2.0 * pi * 10.0) ** 2, rel=1e-9)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_end_stop_halts_the_joint_and_strikes_the_arm(direction: float) -> None:
    plant = Plant(model([FIRST], Drive(dead_time_s=0.0, min_position_rad=-0.05, max_position_rad=0.05)))
    ours = run(plant, np.full(200, direction * 0.4))
    assert (plant.joint_position_rad, plant.joint_velocity_rad_s) == (direction * 0.05, 0.0)
    assert plant.joint_acceleration_rad_s2 == 0.0

    w, lag = 2.0 * pi * 2.6, 2.0 * pi * 20.0

    def slope(time: float, state: Array, moving: bool) -> list[float]:
        joint = float(np.clip(lag * (direction * 0.4 - state[1]), -20.0, 20.0)) if moving else 0.0
        bend = -w * w * state[2] - 0.02 * w * state[3] - 1.14 * LENGTH_M * joint
        return [state[1], joint, state[3], bend]

    def at_stop(time: float, state: Array, moving: bool) -> float:
        return float(abs(state[0]) - 0.05)

    at_stop.terminal = True  # type: ignore[attr-defined]
    options = {"rtol": 1e-10, "atol": 1e-13, "method": "DOP853"}
    free = solve_ivp(slope, (0.0, 0.2), np.zeros(4), args=(True,), events=at_stop, max_step=0.001, **options)
    position, velocity, deflection, rate = free.y[:, -1]
    # the joint's velocity jumps to zero: theta'' is an impulse, which the arm feels as any other theta''
    struck = np.array([position, 0.0, deflection, rate + 1.14 * LENGTH_M * velocity])
    rest = solve_ivp(slope, (free.t[-1], 0.2), struck, args=(False,), **options)
    assert 0.1 < free.t[-1] < 0.15
    assert ours[-1] == pytest.approx(rest.y[:, -1], rel=1e-7)

    for _ in range(20):
        plant.advance(-direction * 0.4)
    assert direction * plant.joint_velocity_rad_s < -0.3
    assert abs(plant.joint_position_rad) < 0.05


def test_a_joint_that_turns_just_beyond_a_stop_within_a_cycle_still_hits_it() -> None:
    drive = Drive(bandwidth_hz=300.0, dead_time_s=0.0, max_acceleration_rad_s2=1e4)
    free = Plant(model([FIRST], drive))
    free.advance(0.5)
    free.advance(0.5)
    velocity, position = free.joint_velocity_rad_s, free.joint_position_rad
    free.advance(-0.5)
    assert velocity > 0.0 > free.joint_velocity_rad_s
    stop = position + 1e-5  # passed within the cycle, at the end of which the free joint is back below it
    assert free.joint_position_rad < stop
    stopped = Plant(
        model(
            [FIRST],
            Drive(bandwidth_hz=300.0, dead_time_s=0.0, max_acceleration_rad_s2=1e4, max_position_rad=stop),
        )
    )
    for command in (0.5, 0.5, -0.5):
        stopped.advance(command)
    assert stopped.joint_position_rad < free.joint_position_rad
    assert stopped.joint_velocity_rad_s < 0.0


def test_the_joint_starts_at_the_stop_nearest_to_zero() -> None:
    plant = Plant(model([FIRST], Drive(min_position_rad=0.1, max_position_rad=0.4)))
    assert plant.joint_position_rad == 0.1


modes_strategy = st.lists(
    st.builds(
        Mode,
        frequency_hz=st.floats(0.1, 400.0),
        damping_ratio=st.floats(0.0, 0.95),
        participation=st.floats(-2.0, 2.0),
    ),
    min_size=1,
    max_size=3,
)


@settings(max_examples=60, deadline=None)
@given(modes_strategy, st.floats(-0.1, 0.1))
def test_energy_never_grows_without_input(modes: list[Mode], struck_m: float) -> None:
    plant = Plant(model(modes))
    for number in range(1, len(modes) + 1):
        plant.strike(number, struck_m)
    stiffness = [mode.angular_frequency**2 for mode in modes]
    previous = [rate**2 for rate in plant.modal_rates_m_s]
    for _ in range(200):
        plant.advance(0.0)
        energy = [
            rate**2 + k * q**2
            for rate, q, k in zip(plant.modal_rates_m_s, plant.modal_deflections_m, stiffness, strict=True)
        ]
        assert all(
            now <= before * (1.0 + 1e-12) + 1e-290 for now, before in zip(energy, previous, strict=True)
        )
        previous = energy


@settings(max_examples=30, deadline=None)
@given(modes_strategy, st.integers(0, 2**32 - 1), st.floats(-3.0, 3.0), st.floats(0.0, 0.01))
def test_linear_while_no_limit_is_met(
    modes: list[Mode], seed: int, factor: float, dead_time_s: float
) -> None:
    drive = Drive(dead_time_s=dead_time_s, max_velocity_rad_s=100.0, max_acceleration_rad_s2=1e6)
    first, second = moves(80, 0.2, seed), moves(80, 0.2, seed + 1)
    a, b, both = (run(Plant(model(modes, drive)), c) for c in (first, second, first + factor * second))
    scale = np.max(np.abs(a), axis=0) + np.max(np.abs(factor * b), axis=0)
    assert np.all(np.abs(both - (a + factor * b)) <= 1e-10 * scale + 1e-14)


@settings(max_examples=60, deadline=None)
@given(
    st.floats(0.5, 1000.0),
    st.floats(0.0, 0.02),
    st.floats(0.01, 5.0),
    st.floats(0.1, 1000.0),
    st.lists(st.floats(-1e9, 1e9), min_size=1, max_size=60),
)
def test_limits_hold_whatever_is_commanded(
    bandwidth_hz: float, dead_time_s: float, velocity: float, acceleration: float, commands: list[float]
) -> None:
    drive = Drive(
        bandwidth_hz=bandwidth_hz,
        dead_time_s=dead_time_s,
        max_velocity_rad_s=velocity,
        max_acceleration_rad_s2=acceleration,
        min_position_rad=-0.002,
        max_position_rad=0.003,
    )
    plant = Plant(model([FIRST], drive))
    for command in commands:
        plant.advance(command)
        assert -0.002 <= plant.joint_position_rad <= 0.003
        assert abs(plant.joint_velocity_rad_s) <= velocity * (1.0 + 1e-9)
        assert abs(plant.joint_acceleration_rad_s2) <= acceleration * (1.0 + 1e-9)
        assert np.isfinite(plant.tip_acceleration_m_s2)


def test_a_command_that_is_no_number_is_an_error() -> None:
    with pytest.raises(ValueError, match="not a number"):
        Plant(model([FIRST])).advance(float("nan"))


class CubicStiffness:
    """w^2 c q^3 on the first mode: what the effect cubic_stiffness will add."""

    def acceleration_m_s2(
        self, mode: int, deflection_m: float, rate_m_s: float, time_s: float, duration_s: float
    ) -> float:
        return -((2.0 * pi * 2.6) ** 2) * 400.0 * deflection_m**3 if mode == 1 else 0.0


def test_a_force_term_and_a_drive_rule_extend_the_equations() -> None:
    of = model([FIRST, SECOND])
    plant = Plant(of, forces=[CubicStiffness()])
    plant.strike(1, 0.03)
    start = np.array([0.0, 0.0, 0.0, 2.0 * pi * 2.6 * 0.03, 0.0, 0.0])
    commands = moves(300, 0.05)
    assert_same(run(plant, commands), solved(of, commands, start, extra=400.0), 1e-4)
    q = plant.modal_deflections_m[0]
    without = Plant(of)
    without._modes, without._joint = plant._modes, plant._joint
    added = plant.tip_acceleration_m_s2 - without.tip_acceleration_m_s2
    assert added == pytest.approx(-((2.0 * pi * 2.6) ** 2) * 400.0 * q**3, rel=1e-6)

    dead_band = Plant(of, rules=[lambda command: 0.0 if abs(command) < 0.2 else command])
    assert np.all(run(dead_band, np.full(20, 0.1))[:, 1] == 0.0)
    assert run(dead_band, np.full(20, 0.3))[-1, 1] > 0.2


def test_an_unsupported_effect_is_refused_by_name() -> None:
    of = Model(arm=Arm(length_m=2.0), effects=[{"cause": "gear_backlash", "gap_rad": 0.001}])
    assert unsupported_effects(of) == ["gear_backlash"]
    with pytest.raises(UserError, match=r"^true\.toml: [^\n]*'gear_backlash'[^\n]*remove[^\n]*$"):
        Plant(of, "true.toml")


def test_a_model_without_a_length_is_refused() -> None:
    with pytest.raises(UserError, match=r"^true\.toml: arm\.length_m: [^\n]*$"):
        Plant(Model(), "true.toml")


def test_strikes_fall_due_once_each_on_their_cycle() -> None:
    scenario = Scenario(strikes=[Strike(0.0205, 0.02), Strike(0.003, 0.01, 2), Strike(0.0, 0.005)])
    disturbance = Disturbance(scenario, 2, CYCLE_S, np.random.default_rng(0))
    fell = [
        (cycle, strike.deflection_m)
        for cycle in range(40)
        for strike in disturbance.strikes_until(cycle * CYCLE_S)
    ]
    assert fell == [(0, 0.005), (3, 0.01), (21, 0.02)]
    assert disturbance.forces_m_s2() == [0.0, 0.0]


def test_a_strike_rings_on_with_its_amplitude() -> None:
    plant = Plant(model([Mode(frequency_hz=2.6, damping_ratio=0.0)]))
    disturbance = Disturbance(Scenario(strikes=[Strike(0.01, -0.006)]), 1, CYCLE_S, np.random.default_rng(0))
    seen = []
    for cycle in range(500):
        disturbance.act_on(plant, cycle * CYCLE_S)
        plant.advance(0.0)
        seen.append(plant.deflection_m)
    assert max(map(abs, seen)) == pytest.approx(0.006, rel=1e-4)
    assert seen[20] < 0.0


def test_a_strike_on_a_mode_that_is_not_there_is_refused() -> None:
    with pytest.raises(UserError, match=r"^scenario: strikes\[0\]\.mode = 3: [^\n]*1 to 2[^\n]*$"):
        Disturbance(Scenario(strikes=[Strike(1.0, 0.01, 3)]), 2, CYCLE_S, np.random.default_rng(0))
    with pytest.raises(IndexError):
        Plant(model([FIRST])).strike(0, 0.01)


@pytest.mark.parametrize("cycle_s", [0.001, 0.004])
def test_random_disturbance_is_white_with_the_stated_level_at_1_khz(cycle_s: float) -> None:
    scenario = Scenario(random_disturbance_m_s2=0.2)
    drawn = Disturbance(scenario, 2, cycle_s, np.random.default_rng(3))
    again = Disturbance(scenario, 2, cycle_s, np.random.default_rng(3))
    forces = np.array([drawn.forces_m_s2() for _ in range(20000)])
    assert np.array_equal(forces[:3000], [again.forces_m_s2() for _ in range(3000)])
    level = 0.2 * sqrt(0.001 / cycle_s)
    assert np.std(forces, axis=0) == pytest.approx([level, level], rel=0.03)
    assert abs(np.corrcoef(forces[1:, 0], forces[:-1, 0])[0, 1]) < 0.03
    assert abs(np.corrcoef(forces.T)[0, 1]) < 0.03


def test_tip_slopes_are_those_of_a_cantilever() -> None:
    for number, slope in enumerate(tip_slopes_per_m(1.0, 8), 1):
        near = (number - 0.5) * pi
        k = brentq(lambda x: cos(x) + 1.0 / cosh(x), near - 0.4, near + 0.4, xtol=1e-14)
        sigma = (cosh(k) + cos(k)) / (sinh(k) + sin(k))
        shape = cosh(k) - cos(k) - sigma * (sinh(k) - sin(k))
        exact = k * (sinh(k) + sin(k) - sigma * (cosh(k) - cos(k))) / shape
        assert slope == pytest.approx(exact, rel=1e-6)
    assert tip_slopes_per_m(2.0, 1)[0] == pytest.approx(tip_slopes_per_m(1.0, 1)[0] / 2.0)
