"""Recordings of every shape that a user brings, each made from a seed: which channels there are, and what is odd.

The motion is that of one arm, integrated here: a joint that follows its command with a lag, one bending mode that is
struck at the beginning and shaken by two moves.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from math import isnan, nan, pi, sqrt
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import cont2discrete, lfilter, ss2tf

Array = NDArray[np.float64]

SEED = 20240517
LENGTH_M, HZ, DAMPING, PARTICIPATION = 2.0, 2.6, 0.01, 1.14
STRUCK_M, BANDWIDTH_HZ, DEAD_TIME_S = 0.02, 20.0, 0.002  # the last two as a model file has them by default
FRAME_HZ, DELAY_S, PX_PER_M = 50.0, 0.07, 800.0
STAMP_OFFSET_S = 311.0  # of the camera's own clock
UNIX_S = 1.7e9

MODEL = f"""[arm]
length_m = {LENGTH_M}
[[arm.modes]]
frequency_hz = 2.58
damping_ratio = {DAMPING}
participation = {PARTICIPATION}
[accelerometer]
noise_std_m_s2 = 0.05
[camera]
frame_rate_hz = {FRAME_HZ}
exposure_s = 0.001
scale_px_per_m = {PX_PER_M}
[timing]
capture_delay_s = {DELAY_S}
capture_delay_std_s = 0.003
"""

JOINT = ("joint_velocity_command_rad_s", "joint_position_rad", "joint_velocity_rad_s")
ACCELERATION, DEFLECTION = ("acceleration_m_s2",), ("deflection_m",)
TORQUE = ("joint_torque_n_m",)
ALL = (*JOINT, *ACCELERATION, *DEFLECTION, *TORQUE)
IMAGES = ("frame", "received_s", "started_s", "displacement_px")

Table = dict[str, Array]
Change = Callable[[Table, Table], None]


@dataclass(frozen=True)
class Shape:
    """One kind of recording. fast, frames: columns that are there; none: no such file. moves: whether the joint does.
    change: what is odd about it, done to the tables in place. arguments: of the import of a single file, beside the
    source and the result.
    """

    fast: tuple[str, ...] | None
    frames: tuple[str, ...] | None = None
    model: str = MODEL
    duration_s: float = 8.0
    rate_hz: float = 1000.0
    moves: bool = True
    change: Change = field(default=lambda fast, frames: None)
    arguments: tuple[str, ...] = ()


def write(shape: Shape, folder: Path) -> list[str]:
    """Write a shape's files into a folder; returns the arguments of `stillarm import`, without the result."""
    folder.mkdir(parents=True)
    if shape.arguments:
        file = folder / "pair.csv"
        _write_csv(file, _pair(shape))
        return ["import", str(file), *shape.arguments]
    fast, frames = _tables(shape)
    shape.change(fast, frames)
    if shape.fast is not None:
        _write_csv(folder / "fast.csv", fast)
    if shape.frames is not None:
        _write_csv(folder / "frames.csv", frames)
    if shape.model:
        (folder / "model.toml").write_text(shape.model)
    return ["import", str(folder)]


def _write_csv(path: Path, table: Table) -> None:
    rows = zip(*(column.tolist() for column in table.values()), strict=True)
    lines = [",".join("" if isnan(value) else repr(value) for value in row) for row in rows]
    path.write_text("\n".join([",".join(table), *lines]) + "\n")


def _tables(shape: Shape) -> tuple[Table, Table]:
    """The two tables, with the shape's columns only."""
    rng = np.random.default_rng(SEED)
    cycle_s = 0.001
    time, command, joint, q, pull = _motion(shape.duration_s, cycle_s, shape.moves)
    theta, omega = joint[:, 0], joint[:, 1]
    tip = LENGTH_M * theta + q
    n = len(time)
    whole = {
        "time_s": time,
        "joint_velocity_command_rad_s": command,
        "joint_position_rad": theta + rng.normal(0.0, 2e-5, n),
        "joint_velocity_rad_s": omega + rng.normal(0.0, 1e-3, n),
        "acceleration_m_s2": pull + rng.normal(0.0, 0.05, n),
        "deflection_m": q + rng.normal(0.0, 1e-5, n),
        "joint_torque_n_m": 0.3 * pull + rng.normal(0.0, 0.01, n),
        "strain": 4e-4 * q + rng.normal(0.0, 1e-8, n),
    }
    every = round(1.0 / (shape.rate_hz * cycle_s))
    fast = {"time_s": time[::every]} | {name: whole[name][::every] for name in shape.fast or ()}
    exposed = np.arange(0.02, shape.duration_s - 0.1, 1.0 / FRAME_HZ)
    received = exposed + DELAY_S + rng.normal(0.0, 0.003, len(exposed))
    received = np.maximum.accumulate(np.rint(received / cycle_s)) * cycle_s
    seen = {
        "frame": np.arange(len(exposed), dtype=float),
        "received_s": received,
        "started_s": np.floor((exposed - 0.01) / cycle_s) * cycle_s,
        "displacement_px": -PX_PER_M * np.interp(exposed, time, tip) + rng.normal(0.0, 0.05, len(exposed)),
        "captured_s": exposed + STAMP_OFFSET_S,
    }
    return fast, {name: seen[name] for name in shape.frames or ()}


def _motion(duration_s: float, cycle_s: float, moves: bool) -> tuple[Array, Array, Array, Array, Array]:
    """Time, command, joint (angle and velocity), deflection, tip acceleration; exact, the command being held."""
    n = round(duration_s / cycle_s)
    time = np.arange(n) * cycle_s
    command = np.zeros(n)
    for begin, speed in ((0.4, 0.15), (0.65, -0.15)):
        if moves:
            command[(time >= begin * duration_s) & (time < begin * duration_s + 0.5)] = speed
    lag, w, push = 2.0 * pi * BANDWIDTH_HZ, 2.0 * pi * HZ, PARTICIPATION * LENGTH_M
    # theta, omega, q, v
    dynamics = np.array(
        [[0, 1, 0, 0], [0, -lag, 0, 0], [0, 0, 0, 1], [0, push * lag, -w * w, -2.0 * DAMPING * w]], float
    )
    drive = np.array([[0], [lag], [0], [-push * lag]], float)
    shown = np.array(
        [
            [1, 0, 0, 0],
            [0, 1, 0, 0],
            [0, 0, 1, 0],
            [0, (push - LENGTH_M) * lag, -w * w, -2.0 * DAMPING * w],
        ],
        float,
    )
    direct = np.array([[0], [0], [0], [(LENGTH_M - push) * lag]], float)
    exact = cont2discrete((dynamics, drive, shown, direct), cycle_s)
    tops, bottom = ss2tf(*exact[:4])
    late = np.concatenate((np.zeros(round(DEAD_TIME_S / cycle_s)), command))[:n]
    theta, omega, q, pull = (lfilter(top, bottom, late) for top in tops)
    wd = w * sqrt(1.0 - DAMPING**2)
    swing = STRUCK_M * np.exp((-DAMPING * w + 1j * wd) * time)
    turn = complex(-DAMPING * w, wd)
    return time, command, np.column_stack((theta, omega)), q + swing.imag, pull + (turn**2 * swing).imag


def _pair(shape: Shape) -> Table:
    """A Duffing oscillator under a slow chirp; the columns that the shape names, changed as it says."""
    rng = np.random.default_rng(SEED)
    n = round(shape.duration_s * shape.rate_hz)
    time = np.arange(n) / shape.rate_hz
    given = np.sin(2.0 * pi * (0.5 + 0.25 * time) * time)
    answer, x, v = np.empty(n), 0.0, 0.0
    step = 0.25 / shape.rate_hz
    for k in range(n):
        answer[k] = x
        for _ in range(4):
            v += (40.0 * given[k] - 0.8 * v - 400.0 * x * (1.0 + 30.0 * x * x)) * step
            x += v * step
    table = {"u": given, "y": answer + rng.normal(0.0, 1e-4, n)}
    shape.change(table, {})
    return table


def constant(*names: str, value: float = 0.25) -> Change:
    """Columns that never change."""

    def change(fast: Table, frames: Table) -> None:
        for table in (fast, frames):
            for name in names:
                if name in table:
                    table[name] = np.full(len(table[name]), value)

    return change


def moved(by_s: float) -> Change:
    """Another start of time."""

    def change(fast: Table, frames: Table) -> None:
        fast["time_s"] = fast["time_s"] + by_s
        for name in ("received_s", "started_s"):
            if name in frames:
                frames[name] = frames[name] + by_s

    return change


def only(rows: Sequence[int] | NDArray[np.int64], frames_too: bool = False) -> Change:
    """These rows, and no others."""

    def change(fast: Table, frames: Table) -> None:
        for table in (fast, frames) if frames_too else (fast,):
            for name in table:
                table[name] = table[name][np.asarray(rows, dtype=np.int64)]

    return change


def frames_only(rows: Sequence[int]) -> Change:
    """These frames, and no others."""

    def change(fast: Table, frames: Table) -> None:
        for name in frames:
            frames[name] = frames[name][np.asarray(rows, dtype=np.int64)]

    return change


def without(spans_s: Iterable[tuple[float, float]]) -> Change:
    """Rows of these times are missing."""

    def change(fast: Table, frames: Table) -> None:
        time = fast["time_s"]
        kept = np.ones(len(time), bool)
        for begin, end in spans_s:
            kept &= (time < begin) | (time >= end)
        for name in fast:
            fast[name] = fast[name][kept]

    return change


def absent(name: str, share: float) -> Change:
    """Empty fields here and there; everywhere for a share of one."""

    def change(fast: Table, frames: Table) -> None:
        rng = np.random.default_rng(SEED + 1)
        for table in (fast, frames):
            if name in table:
                values = table[name].copy()
                values[rng.random(len(values)) < share] = nan
                table[name] = values

    return change


def swapped(count: int) -> Change:
    """Neighbouring rows in the wrong order, at so many places."""

    def change(fast: Table, frames: Table) -> None:
        at = np.linspace(10, len(fast["time_s"]) - 20, count).astype(np.int64)
        order = np.arange(len(fast["time_s"]))
        order[at], order[at + 1] = at + 1, at
        for name in fast:
            fast[name] = fast[name][order]

    return change


def repeated(every: int) -> Change:
    """Rows that come twice, with the same time."""

    def change(fast: Table, frames: Table) -> None:
        count = np.ones(len(fast["time_s"]), np.int64)
        count[::every] = 2
        for name in fast:
            fast[name] = np.repeat(fast[name], count)

    return change


def set_back(at_s: float, by_s: float) -> Change:
    """A clock that was set back in the middle."""

    def change(fast: Table, frames: Table) -> None:
        for table, names in ((fast, ("time_s",)), (frames, ("received_s", "started_s"))):
            for name in names:
                if name in table:
                    table[name] = table[name] - np.where(table[name] >= at_s, by_s, 0.0)

    return change


def scaled(name: str, factor: float) -> Change:
    """A column in another unit, or of another size."""

    def change(fast: Table, frames: Table) -> None:
        for table in (fast, frames):
            if name in table:
                table[name] = table[name] * factor

    return change


PAIR = ("--map", "input=u", "--map", "output=y", "--rate-hz", "100")
_COMMAND = ("joint_velocity_command_rad_s",)

SHAPES: dict[str, Shape] = {
    # which channels there are
    "joint": Shape(JOINT),
    "joint without a command": Shape(JOINT[1:]),
    "joint position alone": Shape(JOINT[1:2]),
    "joint velocity alone": Shape(JOINT[2:]),
    "command alone": Shape(_COMMAND),
    "joint and torque": Shape((*JOINT, *TORQUE)),
    "torque alone": Shape(TORQUE),
    "accelerometer alone": Shape(ACCELERATION, duration_s=7.0, moves=False),
    "images alone": Shape((), IMAGES, moves=False),
    "strain gauge as deflection": Shape(DEFLECTION, moves=False),
    "strain of unknown scale": Shape(("strain",), moves=False),
    "joint and accelerometer": Shape((*JOINT, *ACCELERATION)),
    "joint and images": Shape(JOINT, IMAGES),
    "joint and deflection": Shape((*JOINT, *DEFLECTION)),
    "accelerometer and images": Shape(ACCELERATION, IMAGES, moves=False),
    "command and accelerometer": Shape((*_COMMAND, *ACCELERATION)),
    "position, velocity, accelerometer, images": Shape((*JOINT[1:], *ACCELERATION), IMAGES),
    "all": Shape(ALL, IMAGES),
    "all, stamps": Shape(ALL, (*IMAGES, "captured_s")),
    "all, no model": Shape(ALL, IMAGES, model=""),
    "images without counter and stamps": Shape(ALL, ("received_s", "displacement_px")),
    "arrivals without displacement": Shape((*JOINT, *ACCELERATION), ("frame", "received_s", "started_s")),
    "images alone, no model": Shape((), IMAGES, model="", moves=False),
    "accelerometer alone, no model": Shape(ACCELERATION, model="", moves=False),
    "joint, no model": Shape(JOINT, model=""),
    "frames.csv alone": Shape(None, IMAGES, moves=False),
    "time alone": Shape(()),
    # how much of it
    "one sample": Shape(ALL, change=only([0])),
    "two samples": Shape(ALL, change=only([0, 1])),
    "sixty samples": Shape(ALL, change=only(range(60))),
    "no rows": Shape(ALL, change=only([])),
    "one frame": Shape(JOINT, IMAGES, change=frames_only([40])),
    "no frames": Shape((*JOINT, *ACCELERATION), IMAGES, change=frames_only([])),
    "20 s at 100 Hz": Shape((*JOINT, *ACCELERATION), duration_s=20.0, rate_hz=100.0),
    "20 s at 100 Hz, no model": Shape((*JOINT, *ACCELERATION), duration_s=20.0, rate_hz=100.0, model=""),
    "10 min at 1 kHz": Shape(ACCELERATION, duration_s=600.0, moves=False),
    # what is odd about it
    "Unix epoch seconds": Shape(ALL, IMAGES, change=moved(UNIX_S)),
    "time below zero": Shape(ALL, IMAGES, change=moved(-5.5)),
    "accelerometer constant": Shape(ALL, IMAGES, change=constant("acceleration_m_s2")),
    "accelerometer alone, constant": Shape(ACCELERATION, change=constant("acceleration_m_s2"), moves=False),
    "images constant": Shape(JOINT, IMAGES, change=constant("displacement_px", value=3.0)),
    "deflection constant": Shape((*JOINT, *DEFLECTION), change=constant("deflection_m")),
    "joint constant": Shape((*JOINT, *ACCELERATION), change=constant(*JOINT, value=0.0)),
    "nothing moves": Shape(ALL, IMAGES, change=constant(*ALL, "displacement_px", value=0.0)),
    "rows missing": Shape((*JOINT, *ACCELERATION), change=without([(1.0, 1.3), (4.2, 4.25), (6.5, 7.1)])),
    "accelerometer all NaN": Shape((*JOINT, *ACCELERATION), change=absent("acceleration_m_s2", 1.0)),
    "accelerometer, a third NaN": Shape(ACCELERATION, change=absent("acceleration_m_s2", 0.33), moves=False),
    "images, a third NaN": Shape((), IMAGES, change=absent("displacement_px", 0.33), moves=False),
    "rows out of order": Shape((*JOINT, *ACCELERATION), change=swapped(12)),
    "rows repeated": Shape((*JOINT, *ACCELERATION), change=repeated(50)),
    "clock set back": Shape((*JOINT, *ACCELERATION), IMAGES, change=set_back(4.0, 0.5)),
    "accelerometer in micro-g": Shape(ACCELERATION, change=scaled("acceleration_m_s2", 1e5), moves=False),
    # one input, one output
    "pair": Shape(("u", "y"), duration_s=20.0, rate_hz=100.0, arguments=PAIR),
    "pair of unknown rate": Shape(("u", "y"), rate_hz=100.0, arguments=PAIR[:4]),
    "pair of eight samples": Shape(("u", "y"), duration_s=0.08, rate_hz=100.0, arguments=PAIR),
    "pair, constant input": Shape(
        ("u", "y"), duration_s=6.0, rate_hz=100.0, change=constant("u"), arguments=PAIR
    ),
    "pair, constant output": Shape(
        ("u", "y"), duration_s=6.0, rate_hz=100.0, change=constant("y"), arguments=PAIR
    ),
    "pair, NaN": Shape(("u", "y"), duration_s=10.0, rate_hz=100.0, change=absent("y", 0.1), arguments=PAIR),
    "pair, input all NaN": Shape(
        ("u", "y"), duration_s=10.0, rate_hz=100.0, change=absent("u", 1.0), arguments=PAIR
    ),
    "pair, no such column": Shape(
        ("u", "y"), duration_s=1.0, rate_hz=100.0, arguments=("--map", "input=w", *PAIR[2:])
    ),
}
