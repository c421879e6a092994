"""A case from a seed: rigs far more varied than any one of them is likely."""

from dataclasses import dataclass

import numpy as np

from tests.hidden_world.swings.rig import (
    TICK_S,
    Accelerometer,
    Arrivals,
    Belief,
    Camera,
    Case,
    Event,
    Joint,
    Mode,
)

KINDS = ("pull", "strike", "push", "rock", "move", "already")
"""How the first motion comes about. `already`: the arm swings when the recording begins."""

_FIRST_S = 1.5
_GENTLEST = 0.3
_FARTHEST_PX = 400.0
_LATER = ("strike", "pull", "push", "move", "rock")
_LATER_SHARES = (0.32, 0.22, 0.16, 0.24, 0.06)


@dataclass(frozen=True)
class Arm:
    """What events are drawn for. far_rad: the joint moves by that much at most."""

    frequency_hz: float
    length_m: float
    far_rad: float

    @staticmethod
    def seen_by(camera: Camera, frequency_hz: float, length_m: float) -> "Arm":
        """The scene stays in the image."""
        return Arm(frequency_hz, length_m, min(0.35, _FARTHEST_PX / (camera.scale_px_per_m * length_m)))


def draw(seed: int, kind: str | None = None) -> Case:
    """The case of a seed. kind: of KINDS; without, the seeds take turns. Raises ValueError for another kind."""
    kind = KINDS[seed % len(KINDS)] if kind is None else kind
    if kind not in KINDS:
        raise ValueError(f"kind {kind}: one of {', '.join(KINDS)}")
    luck = np.random.default_rng((seed, 11))
    frequency = log_uniform(luck, 1.0, 10.0)
    w = 2.0 * np.pi * frequency
    length = log_uniform(luck, 0.5, 8.0)
    camera = _camera(luck, frequency)
    noise_m = camera.noise_px / camera.scale_px_per_m
    range_m_s2 = float(luck.choice([19.6, 39.2, 78.4]))
    most_m = min(0.05 * length, 0.6 * range_m_s2 / (w * w))
    amplitude = float(np.clip(log_uniform(luck, 4.0, 400.0) * noise_m, min(4.0 * noise_m, most_m), most_m))
    modes = [Mode(frequency, log_uniform(luck, 0.002, 0.03), float(luck.uniform(1.05, 1.6)))]
    if luck.random() < 0.3:
        push, share = log_uniform(luck, 0.01, 0.1), float(luck.uniform(-0.1, -0.01))
        ratio = float(luck.uniform(4.0, 7.0))
        modes.append(Mode(frequency * ratio, log_uniform(luck, 0.005, 0.03), share, push))
    arm = Arm.seen_by(camera, frequency, length)
    duration = float(round(luck.uniform(35.0, 55.0), 1))
    accelerometer = _accelerometer(luck, w * w * amplitude, range_m_s2)
    return Case(
        seed=seed,
        kind=kind,
        duration_s=duration,
        length_m=length,
        modes=tuple(modes),
        joint=_joint(luck, frequency),
        accelerometer=accelerometer,
        camera=camera,
        arrivals=_arrivals(luck, camera),
        events=tuple(draw_events(luck, kind, arm, amplitude, duration)),
        belief=_belief(luck, accelerometer.bias_m_s2),
        amplitude_m=amplitude,
        swinging_m=amplitude if kind == "already" else 0.0,
    )


def log_uniform(luck: np.random.Generator, low: float, high: float) -> float:
    """A number whose logarithm is uniform."""
    return float(np.exp(luck.uniform(np.log(low), np.log(high))))


def _camera(luck: np.random.Generator, frequency: float) -> Camera:
    rate = log_uniform(luck, max(25.0, 4.0 * frequency), 120.0)
    triggered = bool(luck.random() < 0.25)
    return Camera(
        triggered=triggered,
        frame_rate_hz=float(round(rate)),
        rate_error=float(luck.normal(0.0, 3e-5)),
        exposure_s=float(luck.uniform(0.1, 0.75)) / round(rate),
        scale_px_per_m=log_uniform(luck, 250.0, 1500.0),
        noise_px=log_uniform(luck, 0.02, 0.2),
        colour=float(luck.uniform(0.1, 0.4)) if luck.random() < 0.25 else 0.0,
        offset_px=float(luck.choice([0.0, luck.uniform(-20.0, 20.0)])),
        stamped=bool(luck.random() < 0.4),
    )


def _accelerometer(luck: np.random.Generator, acceleration: float, range_m_s2: float) -> Accelerometer:
    state = str(luck.choice(["good", "dead", "none"], p=[0.84, 0.08, 0.08]))
    return Accelerometer(
        state=state,
        gain=float(1.0 + luck.normal(0.0, 0.005)),
        noise_m_s2=log_uniform(luck, 0.05, 1.0) * acceleration,
        colour=float(luck.uniform(0.1, 0.5)) if luck.random() < 0.25 else 0.0,
        bias_m_s2=float(luck.normal(0.0, 0.06)),
        range_m_s2=range_m_s2,
        age_s=float(luck.uniform(0.1, 0.9)) * 1e-3 if luck.random() < 0.3 else 0.0,
    )


def _joint(luck: np.random.Generator, frequency: float) -> Joint:
    encoder = str(luck.choice(["noisy", "coarse", "none"], p=[0.5, 0.3, 0.2]))
    coarse = encoder == "coarse"
    return Joint(
        bandwidth_hz=float(luck.uniform(8.0, 30.0)) + frequency,
        dead_time_s=float(luck.choice([0.0, round(luck.uniform(0.0, 0.004), 4)])),
        encoder=encoder,
        resolution_rad=log_uniform(luck, 1e-6, 1e-4) if coarse else 1e-7,
        noise_rad=0.0 if coarse else 2e-5,
        speed_noise_rad_s=2e-3,
    )


def _arrivals(luck: np.random.Generator, camera: Camera) -> Arrivals:
    period = 1.0 / camera.frame_rate_hz
    stalls = luck.random() < 0.3
    start = luck.random() < 0.35
    tail = luck.random() < 0.4
    floor = max(0.5 * camera.exposure_s + 0.002, log_uniform(luck, 0.025, 0.15))
    return Arrivals(
        floor_s=float(floor),
        rest_mean_s=min(log_uniform(luck, 0.0015, 0.015), 0.8 * period),
        rest_shape=log_uniform(luck, 0.8, 4.0),
        tail_share=log_uniform(luck, 0.002, 0.03) if tail else 0.0,
        tail_s=float(luck.uniform(0.01, 0.05)),
        walk_s=float(luck.choice([0.0, luck.uniform(0.001, 0.006)])),
        walk_time_s=float(luck.uniform(5.0, 20.0)),
        stall_rate_hz=log_uniform(luck, 0.02, 0.2) if stalls else 0.0,
        stall_s=log_uniform(luck, 0.05, 0.4),
        start_stall_s=float(luck.uniform(0.1, 0.6)) if start else 0.0,
        service_s=float(luck.uniform(0.15, 0.85)) * period,
        lost_share=log_uniform(luck, 0.002, 0.05) if luck.random() < 0.4 else 0.0,
        queue=int(luck.choice([0, 4, 8])),
    )


def _belief(luck: np.random.Generator, bias: float) -> Belief:
    """What `calibrate` leaves; on two rigs in five nobody has measured the delay anew."""
    measured = luck.random() < 0.6
    return Belief(
        frequency=float(1.0 + np.clip(luck.normal(0.0, 0.002), -0.005, 0.005)),
        damping=float(np.exp(luck.normal(0.0, 0.07))),
        participation=float(1.0 + luck.normal(0.0, 0.005)),
        scale=float(1.0 + np.clip(luck.normal(0.0, 0.006), -0.015, 0.015)),
        bandwidth=float(1.0 + luck.normal(0.0, 0.015)),
        accelerometer_noise=float(np.exp(luck.normal(0.0, 0.05))),
        image_noise=float(np.exp(luck.normal(0.0, 0.08))),
        bias_m_s2=float(luck.choice([0.0, bias])),
        delay_error_s=float(luck.normal(0.0, 0.001) if measured else luck.uniform(-0.02, 0.02)),
        delay_spread=log_uniform(luck, 0.7, 1.4),
    )


def draw_events(
    luck: np.random.Generator, kind: str, arm: Arm, amplitude: float, duration: float
) -> list[Event]:
    """What is done with the arm, beginning with `kind`; sizes relative to `amplitude`, m."""
    events: list[Event] = []
    at = _FIRST_S + float(luck.uniform(0.0, 1.0))
    if kind == "already":
        at = float(luck.uniform(4.0, 8.0))
    else:
        events.append(_event(luck, kind, at, arm, amplitude))
        at = events[-1].end_s + float(luck.uniform(2.3, 5.5))
    while True:
        what = str(luck.choice(_LATER, p=_LATER_SHARES))
        event = _event(luck, what, at, arm, log_uniform(luck, _GENTLEST, 1.3) * amplitude)
        if event.end_s > duration - 4.0:
            return events
        events.append(event)
        at = event.end_s + float(luck.uniform(2.3, 5.5) if luck.random() < 0.8 else luck.uniform(0.3, 2.0))


def _event(luck: np.random.Generator, kind: str, at: float, arm: Arm, size: float) -> Event:
    at, sign = round(at, 4), float(luck.choice([-1.0, 1.0]))
    if kind == "strike":
        if luck.random() < 0.5:  # between two samples, so that no sensor sees it
            return Event(kind, float(np.floor(at / TICK_S) + 0.5) * TICK_S, sign * size)
        return Event(kind, at, sign * size, ramp_s=round(float(luck.uniform(0.002, 0.01)), 4))
    if kind == "push":
        ramp = float(luck.uniform(0.3, 1.4)) / arm.frequency_hz
        return Event(kind, at, sign * 0.7 * size, ramp_s=round(max(ramp, 0.05), 4))
    if kind == "pull":
        whole = log_uniform(luck, 0.3, 5.0)
        ramp = round(whole * float(luck.uniform(0.15, 0.85)), 4)
        return Event(kind, at, sign * size, ramp_s=ramp, hold_s=round(whole - ramp, 4))
    if kind == "rock":
        ratio = float(luck.uniform(0.95, 1.05))
        return Event(kind, at, sign * size, hold_s=round(float(luck.uniform(1.0, 4.0)), 4), ratio=ratio)
    return _move(luck, at, arm, sign * size)


def _move(luck: np.random.Generator, at: float, arm: Arm, size: float) -> Event:
    """Half of them short: a period or two, so that the arm swings after it, and so far that it bends by about `size`.
    The others go far, slowly enough to bend by no more.
    """
    w = 2.0 * np.pi * arm.frequency_hz
    if luck.random() < 0.5:
        travel = arm.far_rad * float(luck.uniform(0.1, 1.0))
        slow = max(0.3, np.sqrt(2.0 * np.pi * arm.length_m * travel / (w * w * abs(size))))
        return Event("move", at, float(np.sign(size)) * travel, ramp_s=round(float(min(slow, 3.0)), 4))
    ramp = round(float(luck.uniform(0.7, 2.2)) / arm.frequency_hz, 4)
    acceleration_per_rad = 2.0 * np.pi * arm.length_m / (ramp * ramp)  # largest of the tip
    travel = min(0.8 * abs(size) * w * w / acceleration_per_rad, arm.far_rad)
    return Event("move", at, float(np.sign(size)) * travel, ramp_s=ramp)
