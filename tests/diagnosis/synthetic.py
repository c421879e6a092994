"""Measured data made by the diagnosis' own simulation plus noise: for what is statistics, not physics."""

import numpy as np
from numpy.typing import NDArray

from common.model import Arm, Camera, Mode, Model
from diagnosis.fit import Fit, Split, fit, make_data
from diagnosis.measured import Frames, Measured
from diagnosis.split import interleaved
from diagnosis.world import World

Array = NDArray[np.float64]

MODEL = Model(arm=Arm(length_m=2.0, modes=[Mode()]), camera=Camera(noise_std_px=0.05))
NOISE = {"acceleration": 0.3, "joint_position": 1e-3, "joint_velocity": 5e-3, "displacement": 0.05}
ARRIVAL_STD_S = 0.002


def command(cycles: int, cycle_s: float = 0.001) -> Array:
    """Quick moves to and fro, with rests between."""
    time = np.arange(cycles) * cycle_s
    found: Array = np.zeros(cycles)
    for start, end, speed in ((0.8, 1.4, 0.25), (1.6, 2.3, -0.2), (3.2, 3.9, 0.05), (4.4, 4.9, -0.25)):
        for shift in np.arange(0.0, time[-1], 5.5):
            found[(time >= start + shift) & (time < end + shift)] = speed
            slow = (time >= 2.5 + shift) & (time < 3.0 + shift)
            found[slow] = 0.1 * (time[slow] - 2.5 - shift)
    return found


def empty(seconds: float, model: Model = MODEL) -> Measured:
    """A grid and frames with zeros where there is something to measure."""
    cycle_s = model.timing.cycle_s
    n = round(seconds / cycle_s)
    zero, moves = np.zeros(n), command(n, cycle_s)
    count = np.arange(int((seconds - 0.2) * model.camera.frame_rate_hz), dtype=np.int64)
    late = np.random.default_rng(7).normal(0.0, ARRIVAL_STD_S, len(count))
    received = np.sort(count / model.camera.frame_rate_hz + 0.1 + late)
    frames = Frames(count, received, received - 0.1, np.zeros(len(count)), np.full(len(count), np.nan))
    return Measured(
        "synthetic", cycle_s, 0.0, moves, moves, zero, zero, zero, zero, np.full(n, np.nan), frames, np.empty(0)
    )  # fmt: skip


def measured(
    seconds: float,
    seed: int,
    values: dict[str, float] | None = None,
    impacts: tuple[int, ...] = (),
    model: Model = MODEL,
) -> Measured:
    """What the simulation at these quantities shows, with noise of NOISE."""
    bare = empty(seconds, model)
    world = World(bare, model, impacts)
    vector = world.space.vector()
    vector[world.space.place["jump.0.0.q"]] = 0.02
    for name, value in (values or {}).items():
        vector[world.space.place[name]] = value
    shown = world.predict(vector).channels
    random = np.random.default_rng(seed)
    noisy = {name: shown[name] + random.normal(0.0, NOISE[name], len(shown[name])) for name in NOISE}
    frames = Frames(
        bare.frames.counter,
        bare.frames.received_s,
        bare.frames.started_s,
        noisy["displacement"],
        bare.frames.captured_s,
    )
    return Measured(
        "synthetic", bare.cycle_s, 0.0, bare.command, bare.reference, noisy["acceleration"], noisy["joint_position"],
        noisy["joint_velocity"], bare.joint_age_s, bare.deflection, frames, bare.force,
    )  # fmt: skip


def fitted(data: Measured, *more: str, model: Model = MODEL, split: Split | None = None) -> Fit:
    """The baseline's fit, with more set free."""
    world = World(data, model)
    split = split or interleaved(data.duration_s)
    free = (*world.baseline_names(), *more)
    return fit(make_data(world, split), world.space.vector(), free)
