"""Measurements of a ringing arm for estimators alone: quick enough for many seeded trials, exact, written apart.

The modes ring with a disturbance held over each millisecond; images see them at their own instants. Amplitudes are in
metres; a trial's noise is stated as a fraction of `amplitude_m`.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import ceil, cos, exp, hypot, inf, nan, pi, sin, sqrt

import numpy as np

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.model import Accelerometer, Arm, Camera, Mode, Model, Timing
from stillarm.controller.estimation.estimate import DelayEstimate, Method, Observation
from stillarm.controller.joint.joint_motion import JointMotion
from stillarm.controller.replay.frame_delays import FrameDelays

Array = np.ndarray
CYCLE_S = 0.001


@dataclass
class Ringing:
    """A trial: what truly was at each cycle, and what was measured."""

    deflection: Array
    envelope: Array
    acceleration: Array
    samples: dict[int, list[VisualSample]]
    delays: dict[int, float]  # cycle of reading -> capture delay of the last frame read then
    command: Array


@dataclass
class Trial:
    """What a method said of a trial."""

    error: Array  # at each cycle, fraction of the momentary amplitude
    ratio: Array  # error over stated deviation
    delay_time: Array
    delay_error: Array
    delay_std: Array
    status: list[str] = field(default_factory=list)


def model_for(amplitude_m: float, noise: float, vision: float = 0.01, **changes: object) -> Model:
    """A model whose noise levels are those fractions of the amplitude (as deflection, of its first mode)."""
    modes = changes.pop("modes", None) or [Mode()]
    w = modes[0].angular_frequency  # type: ignore[index]
    return Model(
        arm=Arm(length_m=2.0, modes=modes),  # type: ignore[arg-type]
        accelerometer=Accelerometer(noise_std_m_s2=noise * amplitude_m * w * w),
        camera=Camera(
            exposure_s=0.0,  # an image of this world shows an instant
            noise_std_px=vision * amplitude_m * 800.0,
            mode=changes.pop("mode", "freerun"),
        ),  # type: ignore[arg-type]
        timing=Timing(**changes),  # type: ignore[arg-type]
    )


class RingingMode:
    """One mode under a load held over each cycle, and what excites it."""

    def __init__(
        self, mode: Mode, share_m: float, excitation: str, rest_s: float, random: np.random.Generator
    ) -> None:
        self.mode, self.share, self.excitation, self.random = mode, share_m, excitation, random
        self.q = self.v = self.static = 0.0
        self.w = mode.angular_frequency
        self.next_s, self.struck = rest_s, False
        self.push_s, self.push = -1.0, 0.0

    def force(self, t: float) -> float:
        """Modal acceleration by what excites the mode, m/s^2; strikes jump the rate."""
        w, q, v = self.w, self.q, self.v
        if t >= self.next_s:
            toward = -1.0 if v < 0.0 else 1.0
            if not self.struck:
                self.v += toward * w * 1.3 * self.share
            elif self.excitation == "strikes":
                self.v += toward * w * self.share * (0.5 + 0.2 * self.random.random())
            else:
                self.push_s, self.push = t, toward * w * self.share * 0.6
            again = self.excitation in ("strikes", "pushes")
            self.next_s = t + 3.0 + 1.5 * self.random.random() if again else inf
            self.struck = True
        force = 0.0
        if self.excitation == "pushes" and self.push_s <= t < self.push_s + 0.15:
            force = self.push * (pi / 0.3) * sin(pi * (t - self.push_s) / 0.15)
        if self.excitation == "steady" and hypot(q, v) > 0.0:
            force = 2.0 * self.mode.damping_ratio * w * v * (1.0 + 1.5 * cos(2 * pi * t / 6.0))
        return force

    def after(self, dt: float) -> tuple[float, float]:
        """Deflection and rate dt later under the load of this cycle."""
        w, zeta = self.w, self.mode.damping_ratio
        wd = w * sqrt(1.0 - zeta * zeta)
        e, c, s = exp(-zeta * w * dt), cos(wd * dt), sin(wd * dt)
        r, v = self.q - self.static, self.v
        return (
            self.static + e * (r * (c + zeta * w / wd * s) + v * s / wd),
            e * (v * (c - zeta * w / wd * s) - r * w * w / wd * s),
        )


def late_by(
    delay: str, count: int, period_s: float, random: np.random.Generator, wander_s: float = 8.0
) -> Array:
    """Capture delays, s: constant | drift (over wander_s, 6.4 ms) | white (6.4 ms), all 74 ms in the mean."""
    if delay == "constant":
        return np.full(count, 0.074)
    steps = random.standard_normal(count)
    if delay == "drift":
        keep = exp(-period_s / wander_s)
        for k in range(1, count):
            steps[k] = keep * steps[k - 1] + sqrt(1.0 - keep * keep) * steps[k]
    return 0.074 + 0.0064 * steps


def ring(
    model: Model, seed: int, duration_s: float, *, amplitude_m: float = 0.006, excitation: str = "strikes",
    delay: str = "constant", triggered: bool = False, stamped: bool = False,
    frequency: Callable[[float], float] = lambda t: 1.0, scale_factor: Callable[[float], float] = lambda t: 1.0,
    lost: float = 0.0, command: Callable[[float], float] = lambda t: 0.0, offset_px: float = 20.0, rest_s: float = 0.0,
    bias_m_s2: float = 0.1, started_ahead: Callable[[float], float] | None = None, wander_s: float = 8.0,
) -> Ringing:  # fmt: skip
    """Draw one trial. excitation: strikes | pushes (smooth, 0.15 s) | steady (amplitude swings smoothly) | once.

    wander_s: within which the delay `drift` forgets.
    started_ahead: by how much n_i precedes mid-exposure in the mean at a time, s, with a quarter frame of white noise;
    None: n_i is always 0.
    """
    random = np.random.default_rng(seed)
    n = int(duration_s / CYCLE_S)
    length, period = model.arm.length_m, 1.0 / model.camera.frame_rate_hz
    assert length is not None
    commands = np.array([command(k * CYCLE_S) for k in range(n)])
    joint = JointMotionReference(model, commands)
    count = int(duration_s / period) - 1
    mid = 0.003 + period * random.random() + np.arange(count) * period * (1.0 + 1e-4 * random.uniform(-1, 1))
    if triggered:
        mid += 0.005 * random.uniform(-1.0, 1.0, count)
    arrival = np.maximum.accumulate(mid + late_by(delay, count, period, random, wander_s))
    deflection, envelope, acceleration = np.zeros(n), np.zeros(n), length * joint.acceleration + bias_m_s2
    seen = np.zeros(count)
    for index, mode in enumerate(model.arm.modes):
        ringing = RingingMode(mode, amplitude_m * (0.15 if index else 1.0), excitation, rest_s, random)
        lever, frame = mode.participation * length, 0
        for k in range(n):
            t = k * CYCLE_S
            ringing.w = mode.angular_frequency * (1.0 if index else frequency(t))
            force = ringing.force(t)
            w, q, v = ringing.w, ringing.q, ringing.v
            ringing.static = (force - lever * joint.mean_acceleration[k]) / (w * w)
            deflection[k] += q
            envelope[k] += hypot(q, v / w)
            acceleration[k] += (
                force - lever * joint.acceleration[k] - w * w * q - 2 * mode.damping_ratio * w * v
            )
            while frame < count and mid[frame] < t + CYCLE_S:
                seen[frame] += ringing.after(mid[frame] - t)[0]
                frame += 1
            ringing.q, ringing.v = ringing.after(CYCLE_S)
    noise = model.accelerometer.noise_std_m_s2 * random.standard_normal(n)
    tip = length * np.interp(mid, np.arange(n) * CYCLE_S, joint.position) + seen
    tip *= [scale_factor(t) for t in mid]
    camera = model.camera
    pixels = offset_px - camera.scale_px_per_m * tip + camera.noise_std_px * random.standard_normal(count)
    stamps = 1234.5 + mid * (1.0 + 2e-4 * random.uniform(-1, 1))
    begun = np.zeros(count, dtype=int)
    if started_ahead is not None:
        white = 0.25 * period * np.random.default_rng((seed, 1)).standard_normal(count)
        begun = np.array([int((t - started_ahead(t)) / CYCLE_S) for t in mid + white])
    samples: dict[int, list[VisualSample]] = {}
    truth: dict[int, float] = {}
    for k in np.flatnonzero(random.random(count) >= lost).tolist():
        cycle = ceil(arrival[k] / CYCLE_S)
        stamp = float(stamps[k]) if stamped else nan
        samples.setdefault(cycle, []).append(
            VisualSample(k, max(int(begun[k]), 0), 0, float(pixels[k]), captured_s=stamp)
        )
        truth[cycle] = cycle * CYCLE_S - mid[k]
    return Ringing(
        deflection, envelope, model.accelerometer.scale * acceleration + noise, samples, truth, commands
    )


class JointMotionReference:
    """Joint position and acceleration that follow from commands by the drive's first-order lag and dead time."""

    def __init__(self, model: Model, commands: Array) -> None:
        late = round(model.drive.dead_time_s / CYCLE_S)
        rate = 2 * np.pi * model.drive.bandwidth_hz
        velocity = position = 0.0
        n = len(commands)
        self.position, self.acceleration, self.mean_acceleration = np.zeros(n), np.zeros(n), np.zeros(n)
        for k in range(len(commands)):
            wanted = commands[k - late] if k >= late else 0.0
            self.position[k], self.acceleration[k] = position, rate * (wanted - velocity)
            after = wanted + (velocity - wanted) * np.exp(-rate * CYCLE_S)
            self.mean_acceleration[k] = (after - velocity) / CYCLE_S
            position += 0.5 * CYCLE_S * (velocity + after)
            velocity = after


def judge(
    method: Method, model: Model, ringing: Ringing, change: Callable[[int, float], float] = lambda k, a: a
) -> Trial:
    """Run a method over a trial. change(cycle, acceleration): what becomes of an accelerometer's sample."""
    length = model.arm.length_m
    assert length is not None
    joint = JointMotion(model, length)
    n = len(ringing.deflection)
    error, ratio = np.full(n, np.nan), np.full(n, np.nan)
    of_frame: list[tuple[int, DelayEstimate]] = []
    delays, status = FrameDelays(), []
    for cycle in range(n):
        joint.begin_cycle(cycle, float("nan"))
        samples = ringing.samples.get(cycle, [])
        said = method.update(
            Observation(
                cycle, cycle * CYCLE_S, change(cycle, float(ringing.acceleration[cycle])), samples, joint
            )
        )
        joint.send(float(ringing.command[cycle]))
        off = said.deflection_m - ringing.deflection[cycle]
        error[cycle] = off / max(ringing.envelope[cycle], 1e-12)
        ratio[cycle] = off / said.deflection_std_m if said.deflection_std_m else np.nan
        status.append(str(said.delay.status))
        of_frame.extend((cycle if sample is samples[-1] else -1, said.delay) for sample in samples)
        for place, delay in delays.told(samples, said):
            of_frame[place] = of_frame[place][0], delay
    of_frame = [
        (cycle, delay) for cycle, delay in of_frame if cycle >= 0
    ]  # the truth is known of a cycle's last
    times = [cycle * CYCLE_S for cycle, _ in of_frame]
    delay_errors = [delay.delay_s - ringing.delays[cycle] for cycle, delay in of_frame]
    delay_stds = [delay.std_s for _, delay in of_frame]
    return Trial(error, ratio, np.array(times), np.array(delay_errors), np.array(delay_stds), status)
