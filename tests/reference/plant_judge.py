"""An independent solution of the plant's equations, by scipy at rtol 1e-10, and models to hold it against."""

from itertools import pairwise
from math import pi

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from stillarm.common.files.model import Arm, Drive, Mode, Model
from stillarm.simulation.arm.plant import Plant

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
