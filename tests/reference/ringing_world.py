"""Measurements of a ringing arm for estimators alone: quick enough for many seeded trials, exact, written apart.

The modes ring with a disturbance held over each millisecond; images see them at their own instants. Amplitudes are in
metres; a trial's noise is stated as a fraction of `amplitude_m`.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from common.model import Accelerometer, Arm, Camera, Mode, Model, Timing
from common.visual_sample import VisualSample
from controller.estimate import Method, Observation
from controller.joint_motion import JointMotion

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
    scale = float(changes.pop("scale_px_per_m", 800.0))  # type: ignore[arg-type]
    return Model(
        arm=Arm(length_m=2.0, modes=modes),  # type: ignore[arg-type]
        accelerometer=Accelerometer(noise_std_m_s2=noise * amplitude_m * w * w),
        camera=Camera(
            noise_std_px=vision * amplitude_m * abs(scale),
            scale_px_per_m=scale,
            mode=changes.pop("mode", "freerun"),
        ),  # type: ignore[arg-type]
        timing=Timing(**changes),  # type: ignore[arg-type]
    )


def ring(
    model: Model, seed: int, duration_s: float, *, amplitude_m: float = 0.006, excitation: str = "strikes",
    delay: str = "constant", triggered: bool = False, stamped: bool = False, noise_factor: float = 1.0,
    frequency: Callable[[float], float] = lambda t: 1.0, scale_factor: Callable[[float], float] = lambda t: 1.0,
    lost: float = 0.0, command: Callable[[float], float] = lambda t: 0.0, offset_px: float = 20.0, rest_s: float = 0.0,
    bias_m_s2: float = 0.1,
) -> Ringing:  # fmt: skip
    """Draw one trial. excitation: strikes | pushes (smooth, 0.15 s) | steady (amplitude swings smoothly) | once."""
    random = np.random.default_rng(seed)
    n = int(duration_s / CYCLE_S)
    length, camera = model.arm.length_m, model.camera
    assert length is not None
    times = np.arange(n) * CYCLE_S
    commands = np.array([command(t) for t in times])
    joint = JointMotionReference(model, commands)
    period = 1.0 / camera.frame_rate_hz
    count = int(duration_s / period) - 1
    base = 0.003 + period * random.random() + np.arange(count) * period * (1.0 + 1e-4 * random.uniform(-1, 1))
    mid = base + (0.005 * random.uniform(-1.0, 1.0, count) if triggered else 0.0)
    mean, spread = 0.074, 0.0064
    if delay == "constant":
        delays = np.full(count, mean)
    elif delay == "drift":
        keep = np.exp(-period / 8.0)
        walk, state = np.empty(count), random.standard_normal()
        for k in range(count):
            walk[k] = state
            state = keep * state + np.sqrt(1 - keep**2) * random.standard_normal()
        delays = mean + spread * walk
    else:
        delays = mean + spread * random.standard_normal(count)
    arrival = np.maximum.accumulate(mid + delays)
    modes = model.arm.modes
    tip_q = np.zeros(n)
    tip_a = np.zeros(n)
    seen = np.zeros(count)
    envelope = np.zeros(n)
    for index, mode in enumerate(modes):
        share = amplitude_m * (1.0 if index == 0 else 0.15)
        q, v = 0.0, 0.0
        next_strike = rest_s
        frame = 0
        kick_until, kick, phase = -1.0, 0.0, 0.0
        for k in range(n):
            t = times[k]
            w = mode.angular_frequency * (frequency(t) if index == 0 else 1.0)
            zeta = mode.damping_ratio
            amplitude = np.hypot(q, v / w)
            force = 0.0
            if t >= next_strike:
                first = next_strike == rest_s
                if excitation == "strikes" or first:
                    size = 1.3 * share if first else share * (0.5 + 0.2 * random.random())
                    v += np.sign(v if v else 1.0) * w * size
                elif excitation == "pushes":
                    kick_until, kick = t + 0.15, np.sign(v) * w * share * 0.6
                    phase = t
                next_strike = t + (1e9 if excitation in ("once", "steady") else 3.0 + 1.5 * random.random())
            if t < kick_until:
                force = kick * (np.pi / 0.3) * np.sin(np.pi * (t - phase) / 0.15)
            if excitation == "steady" and amplitude > 0:
                force = 2.0 * zeta * w * v * (1.0 + 1.5 * np.cos(2 * np.pi * t / 6.0))
            load = -mode.participation * length * joint.mean_acceleration[k] + force
            tip_q[k] += q
            envelope[k] += amplitude
            instant = load - mode.participation * length * (
                joint.acceleration[k] - joint.mean_acceleration[k]
            )
            tip_a[k] += -w * w * q - 2 * zeta * w * v + instant
            wd = w * np.sqrt(1 - zeta * zeta)
            static = load / w**2

            def moved(dt: float, q=q, v=v, w=w, wd=wd, zeta=zeta, static=static) -> tuple[float, float]:  # type: ignore[no-untyped-def]
                e, c, s = np.exp(-zeta * w * dt), np.cos(wd * dt), np.sin(wd * dt)
                r = q - static
                return (
                    static + e * (r * (c + zeta * w / wd * s) + v * s / wd),
                    e * (v * (c - zeta * w / wd * s) - r * w * w / wd * s),
                )

            while frame < count and mid[frame] < t + CYCLE_S:
                seen[frame] += moved(mid[frame] - t)[0] if mid[frame] >= t else q
                frame += 1
            q, v = moved(CYCLE_S)
    acceleration = model.accelerometer.scale * (length * joint.acceleration + tip_a) + bias_m_s2
    acceleration += noise_factor * model.accelerometer.noise_std_m_s2 * random.standard_normal(n)
    theta = np.interp(mid, times, joint.position)
    samples: dict[int, list[VisualSample]] = {}
    truth: dict[int, float] = {}
    skew = 1.0 + 2e-4 * random.uniform(-1, 1)
    for k in range(count):
        if random.random() < lost:
            continue
        cycle = int(np.ceil(arrival[k] / CYCLE_S))
        tip = scale_factor(mid[k]) * (length * theta[k] + seen[k])
        pixels = -camera.scale_px_per_m * tip + offset_px + camera.noise_std_px * random.standard_normal()
        stamp = 1234.5 + skew * mid[k] if stamped else float("nan")
        samples.setdefault(cycle, []).append(
            VisualSample(k, max(0, cycle - 80), 0, float(pixels), captured_s=stamp)
        )
        truth[cycle] = cycle * CYCLE_S - mid[k]
    return Ringing(tip_q, envelope, acceleration, samples, truth, commands)


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
    times, delay_errors, delay_stds, status = [], [], [], []
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
        if samples:
            times.append(cycle * CYCLE_S)
            delay_errors.append(said.delay.delay_s - ringing.delays[cycle])
            delay_stds.append(said.delay.std_s)
    return Trial(error, ratio, np.array(times), np.array(delay_errors), np.array(delay_stds), status)
