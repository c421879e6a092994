"""An arm, an accelerometer and a late image for tests, written apart from simulation/ and controller/.

Integrated by fourth-order Runge-Kutta at a tenth of the controller's cycle; the image is the position at
mid-exposure, late by a delay that is known exactly.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import exp, pi

import numpy as np

from common.model import Model
from common.visual_sample import VisualSample
from controller.step import Controller, CycleInput, CycleOutput

SUBSTEPS = 10
State = tuple[float, float, float, float]  # theta, theta', q, q'


@dataclass
class Trace:
    """What happened, one row a cycle (or a frame)."""

    time: list[float] = field(default_factory=list)
    truth: list[float] = field(default_factory=list)
    estimate: list[float] = field(default_factory=list)
    estimate_std: list[float] = field(default_factory=list)
    command: list[float] = field(default_factory=list)
    joint: list[float] = field(default_factory=list)
    outputs: list[CycleOutput] = field(default_factory=list)
    delay_time: list[float] = field(default_factory=list)
    delay_error: list[float] = field(default_factory=list)
    delay_std: list[float] = field(default_factory=list)

    def arrays(self) -> dict[str, np.ndarray]:
        """The numeric columns."""
        return {name: np.array(value) for name, value in vars(self).items() if name != "outputs"}


def run_world(
    model: Model,
    controller: Controller,
    duration_s: float,
    *,
    strikes: dict[float, float],
    delay: Callable[[np.random.Generator, int], np.ndarray],
    seed: int = 0,
    started_before_mid_s: float = 0.0,
    accelerometer_noise: float = 0.0,
    image_noise_px: float = 0.0,
    image_offset_px: float = 0.0,
    frequency_factor: float = 1.0,
    reference: Callable[[float], float] = lambda t: 0.0,
    damping: Callable[[float], bool] = lambda t: False,
    change_input: Callable[[CycleInput], None] = lambda read: None,
) -> Trace:
    """Run the controller against the arm of `model` (first mode) for a while.

    strikes: time -> amplitude, m. delay(random, frames): capture delay of each frame, up to its arrival.
    """
    random = np.random.default_rng(seed)
    h = model.timing.cycle_s / SUBSTEPS
    mode, length = model.arm.modes[0], model.arm.length_m
    assert length is not None
    w = 2.0 * pi * mode.frequency_hz * frequency_factor
    rate = 2.0 * pi * model.drive.bandwidth_hz
    wait = round(model.drive.dead_time_s / h)
    under_way = [0.0] * (wait + 1)

    decay, stiffness, lever = 2.0 * mode.damping_ratio * w, w * w, mode.participation * length

    def slope(x: State, command: float) -> State:
        acceleration = rate * (command - x[1])
        return (x[1], acceleration, x[3], -decay * x[3] - stiffness * x[2] - lever * acceleration)

    def moved(x: State, k: State, by: float) -> State:
        return (x[0] + by * k[0], x[1] + by * k[1], x[2] + by * k[2], x[3] + by * k[3])

    frames = int(duration_s * model.camera.frame_rate_hz)
    mid = 0.004 + np.arange(frames) / model.camera.frame_rate_hz
    arrival = np.maximum.accumulate(mid + delay(random, frames))
    seen = np.zeros(frames)
    exposed = arrived = 0
    x: State = (0.0, 0.0, 0.0, 0.0)
    command = 0.0
    trace = Trace()
    pending = sorted(strikes.items())
    for cycle in range(int(duration_s / model.timing.cycle_s)):
        t = cycle * model.timing.cycle_s
        while pending and pending[0][0] <= t:
            x = (x[0], x[1], x[2], x[3] + w * pending.pop(0)[1])
        acceleration = slope(x, under_way[0])
        tip = length * acceleration[1] + acceleration[3]
        samples = []
        while arrived < frames and arrival[arrived] <= t:
            noise = image_noise_px * random.standard_normal()
            started = int((mid[arrived] - started_before_mid_s) / model.timing.cycle_s)
            samples.append(
                VisualSample(
                    arrived,
                    max(0, started),
                    0,
                    displacement_x_px=float(seen[arrived] + image_offset_px + noise),
                )
            )
            arrived += 1
        read = CycleInput(
            cycle,
            model.accelerometer.scale * tip + accelerometer_noise * random.standard_normal(),
            float(x[0]),
            float(x[1]),
            0.0,
            reference(t),
            damping(t),
            samples,
        )
        change_input(read)
        output = controller.step(read)
        command = output.command_rad_s
        trace.time.append(t)
        trace.truth.append(float(x[2]))
        trace.estimate.append(output.estimate.deflection_m)
        trace.estimate_std.append(output.estimate.deflection_std_m)
        trace.command.append(command)
        trace.joint.append(float(x[0]))
        trace.outputs.append(output)
        if samples:
            trace.delay_time.append(t)
            trace.delay_error.append(output.estimate.delay.delay_s - (t - mid[arrived - 1]))
            trace.delay_std.append(output.estimate.delay.std_s)
        for _ in range(SUBSTEPS):
            under_way.append(command)
            now = under_way.pop(0)
            before = x
            k1 = slope(x, now)
            k2 = slope(moved(x, k1, 0.5 * h), now)
            k3 = slope(moved(x, k2, 0.5 * h), now)
            k4 = slope(moved(x, k3, h), now)
            for weight, k in ((1, k1), (2, k2), (2, k3), (1, k4)):
                x = moved(x, k, weight * h / 6.0)
            t += h
            while exposed < frames and mid[exposed] <= t:
                share = (mid[exposed] - (t - h)) / h
                angle, bend = (before[i] + share * (x[i] - before[i]) for i in (0, 2))
                seen[exposed] = -model.camera.scale_px_per_m * (length * angle + bend)
                exposed += 1
    return trace


def constant(delay_s: float) -> Callable[[np.random.Generator, int], np.ndarray]:
    """The same delay for every frame."""
    return lambda random, frames: np.full(frames, delay_s)


def white(delay_s: float, std_s: float) -> Callable[[np.random.Generator, int], np.ndarray]:
    """Independent delays."""
    return lambda random, frames: delay_s + std_s * random.standard_normal(frames)


def wandering(
    delay_s: float, std_s: float, time_s: float, frame_s: float = 1 / 65
) -> Callable[[np.random.Generator, int], np.ndarray]:
    """A first-order Gauss-Markov delay."""

    def draw(random: np.random.Generator, frames: int) -> np.ndarray:
        keep = exp(-frame_s / time_s)
        state = random.standard_normal()
        out = np.empty(frames)
        for k in range(frames):
            out[k] = delay_s + std_s * state
            state = keep * state + (1 - keep * keep) ** 0.5 * random.standard_normal()
        return out

    return draw
