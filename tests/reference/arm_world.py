"""An arm, an accelerometer and a late image for tests, written apart from simulation/ and controller/.

Integrated by fourth-order Runge-Kutta at a tenth of the controller's cycle; the image is the position at
mid-exposure, late by a delay that is known exactly.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import exp, pi

import numpy as np

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.model import Model
from stillarm.controller.estimation.estimate import DelayEstimate
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.loop.step import Controller, CycleOutput
from stillarm.controller.replay.frame_delays import FrameDelays

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

    def add(self, time_s: float, state: State, output: CycleOutput) -> None:
        """One cycle."""
        self.time.append(time_s)
        self.truth.append(state[2])
        self.joint.append(state[0])
        self.estimate.append(output.estimate.deflection_m)
        self.estimate_std.append(output.estimate.deflection_std_m)
        self.command.append(output.command_rad_s)
        self.outputs.append(output)

    def add_delay(self, frame: int, read_s: float, delay: DelayEstimate, true_delay_s: float) -> None:
        """What is said of a frame: when it was read, or better later."""
        self.delay_time[frame:] = [read_s, *self.delay_time[frame + 1 :]]
        self.delay_error[frame:] = [delay.delay_s - true_delay_s, *self.delay_error[frame + 1 :]]
        self.delay_std[frame:] = [delay.std_s, *self.delay_std[frame + 1 :]]

    def arrays(self) -> dict[str, np.ndarray]:
        """The numeric columns."""
        return {name: np.array(value) for name, value in vars(self).items() if name != "outputs"}


class Arm:
    """theta, theta', q, q' of a joint with a lag and a dead time, and of one mode."""

    def __init__(self, model: Model, frequency_factor: float) -> None:
        mode, length = model.arm.modes[0], model.arm.length_m
        assert length is not None
        self.h = model.timing.cycle_s / SUBSTEPS
        self.length = length
        self.w = 2.0 * pi * mode.frequency_hz * frequency_factor
        self.decay, self.lever = 2.0 * mode.damping_ratio * self.w, mode.participation * length
        self.rate = 2.0 * pi * model.drive.bandwidth_hz
        self.under_way = [0.0] * (round(model.drive.dead_time_s / self.h) + 1)
        self.held = 0.0  # deflection by a force at the tip, in balance, m
        self.x: State = (0.0, 0.0, 0.0, 0.0)

    def slope(self, x: State, command: float) -> State:
        acceleration = self.rate * (command - x[1])
        bend = -self.decay * x[3] - self.w * self.w * (x[2] - self.held) - self.lever * acceleration
        return (x[1], acceleration, x[3], bend)

    def strike(self, amplitude_m: float) -> None:
        self.x = (*self.x[:3], self.x[3] + self.w * amplitude_m)

    def tip_acceleration(self) -> float:
        slope = self.slope(self.x, self.under_way[0])
        return self.length * slope[1] + slope[3]

    def tip_position(self) -> float:
        return self.length * self.x[0] + self.x[2]

    def advance(self, command: float) -> None:
        """One step of h by the classical Runge-Kutta method."""
        self.under_way.append(command)
        now, h, x = self.under_way.pop(0), self.h, self.x

        def moved(k: State, by: float) -> State:
            return (x[0] + by * k[0], x[1] + by * k[1], x[2] + by * k[2], x[3] + by * k[3])

        k1 = self.slope(x, now)
        k2 = self.slope(moved(k1, 0.5 * h), now)
        k3 = self.slope(moved(k2, 0.5 * h), now)
        k4 = self.slope(moved(k3, h), now)
        self.x = tuple(
            a + h / 6.0 * (b + 2 * c + 2 * d + e) for a, b, c, d, e in zip(x, k1, k2, k3, k4, strict=True)
        )  # type: ignore[assignment]


class Images:
    """Frames exposed at a steady rate, each arriving late by its own delay."""

    def __init__(self, model: Model, mid: np.ndarray, arrival: np.ndarray) -> None:
        self.mid, self.arrival = mid, arrival
        self.scale, self.cycle_s = model.camera.scale_px_per_m, model.timing.cycle_s
        self.seen: list[float] = []
        self.arrived = 0

    def expose(self, before: tuple[float, float], after: tuple[float, float]) -> None:
        """The tip moved from (time, position) to (time, position): note the frames exposed in between."""
        while len(self.seen) < len(self.mid) and self.mid[len(self.seen)] <= after[0]:
            self.seen.append(
                -self.scale * float(np.interp(self.mid[len(self.seen)], *zip(before, after, strict=True)))
            )

    def read(
        self, time_s: float, started_before_mid_s: float, error_px: Callable[[], float]
    ) -> list[VisualSample]:
        """What has arrived by a time, and was not read before."""
        samples = []
        while self.arrived < len(self.arrival) and self.arrival[self.arrived] <= time_s:
            started = max(0, int((self.mid[self.arrived] - started_before_mid_s) / self.cycle_s))
            displacement = self.seen[self.arrived] + error_px()
            samples.append(VisualSample(self.arrived, started, 0, displacement_x_px=displacement))
            self.arrived += 1
        return samples


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
    held_m: Callable[[float], float] = lambda t: 0.0,
    change_input: Callable[[CycleInput], None] = lambda read: None,
) -> Trace:
    """Run the controller against the arm of `model` (first mode) for a while.

    strikes: time -> amplitude, m. delay(random, frames): capture delay of each frame, up to its arrival.
    held_m(time): static deflection by a force at the tip, m.
    """
    random = np.random.default_rng(seed)
    frames = int(duration_s * model.camera.frame_rate_hz)
    mid = 0.004 + np.arange(frames) / model.camera.frame_rate_hz
    arm = Arm(model, frequency_factor)
    images = Images(model, mid, np.maximum.accumulate(mid + delay(random, frames)))
    trace, pending = Trace(), sorted(strikes.items())
    delays, read_s = FrameDelays(), list[float]()
    for cycle in range(int(duration_s / model.timing.cycle_s)):
        t = cycle * model.timing.cycle_s
        while pending and pending[0][0] <= t:
            arm.strike(pending.pop(0)[1])
        arm.held = held_m(t)
        acceleration = model.accelerometer.scale * arm.tip_acceleration()
        samples = images.read(
            t, started_before_mid_s, lambda: image_offset_px + image_noise_px * random.standard_normal()
        )
        read = CycleInput(
            cycle,
            acceleration + accelerometer_noise * random.standard_normal(),
            arm.x[0],
            arm.x[1],
            0.0,
            reference(t),
            damping(t),
            samples,
        )
        change_input(read)
        output = controller.step(read)
        trace.add(t, arm.x, output)
        read_s.extend(t for _ in samples)
        for frame, said in delays.told(samples, output.estimate):
            trace.add_delay(frame, read_s[frame], said, read_s[frame] - images.mid[frame])
        for k in range(SUBSTEPS):
            before = t + k * arm.h, arm.tip_position()
            arm.advance(output.command_rad_s)
            images.expose(before, (t + (k + 1) * arm.h, arm.tip_position()))
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
