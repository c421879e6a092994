"""What is measured of a motion."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from tests.hidden_world.swings.arrivals import Images, images
from tests.hidden_world.swings.motion import Motion, move
from tests.hidden_world.swings.rig import STEP_S, TICK_S, Case

Values = NDArray[np.float64]


@dataclass(frozen=True)
class Recording:
    """fast: columns of a row a cycle; what is not measured is left out. image_px: shape (images,).

    swings_s: where the arm swings freely, large enough to be seen.
    """

    case: Case
    motion: Motion
    fast: dict[str, Values]
    images: Images
    image_px: Values
    swings_s: list[tuple[float, float]]


_SHORTEST_SWING_S = 2.0
_LEAST_SEEN = 3.0
"""Amplitude that a swing has at least, in deviations of an image's noise."""


def make(case: Case) -> Recording:
    """A case as it is recorded."""
    motion, seen = move(case), images(case)
    cycles = round(case.duration_s / TICK_S)
    read_s = np.arange(cycles) * TICK_S
    fast = {"time_s": read_s}
    if case.accelerometer.state != "none":
        fast["acceleration_m_s2"] = _acceleration(case, motion, read_s)
    fast["joint_velocity_command_rad_s"] = motion.command_rad_s
    if case.joint.encoder != "none":
        fast |= _encoder(case, motion, read_s)
    swings = [(a, b) for a, b in free_spans(case) if _is_seen(case, motion, a, b)]
    return Recording(case, motion, fast, seen, _displacement(case, motion, seen), swings)


def coloured(luck: np.random.Generator, count: int, colour: float) -> Values:
    """Noise of unit variance, each value correlated with the next by `colour`."""
    white = luck.normal(0.0, np.sqrt(1.0 - colour * colour), count)
    white[0] /= np.sqrt(1.0 - colour * colour)
    return np.asarray(lfilter([1.0], [1.0, -colour], white))


def _acceleration(case: Case, motion: Motion, read_s: Values) -> Values:
    feeler, luck = case.accelerometer, np.random.default_rng((case.seed, 41))
    if feeler.state == "dead":
        return np.full(len(read_s), feeler.bias_m_s2)
    true = np.interp(read_s - feeler.age_s, motion.time_s, motion.acceleration_m_s2)
    noise = feeler.noise_m_s2 * coloured(luck, len(read_s), feeler.colour)
    out = feeler.gain * true + feeler.bias_m_s2 + noise
    return np.asarray(np.clip(out, -feeler.range_m_s2, feeler.range_m_s2))


def _encoder(case: Case, motion: Motion, read_s: Values) -> dict[str, Values]:
    joint, luck = case.joint, np.random.default_rng((case.seed, 42))
    theta = (
        np.interp(read_s, motion.time_s, motion.theta_rad)
        + luck.normal(0.0, 1.0, len(read_s)) * joint.noise_rad
    )
    speed = np.interp(read_s, motion.time_s, motion.speed_rad_s)
    step = joint.resolution_rad
    return {
        "joint_position_rad": np.round(theta / step) * step,
        "joint_velocity_rad_s": speed + luck.normal(0.0, 1.0, len(read_s)) * joint.speed_noise_rad_s,
    }


def _displacement(case: Case, motion: Motion, seen: Images) -> Values:
    """The mean over the exposure, from the integral of the tip's position."""
    camera, luck = case.camera, np.random.default_rng((case.seed, 43))
    s = motion.tip_m
    integral = np.concatenate(([0.0], np.cumsum(0.5 * (s[1:] + s[:-1]) * STEP_S)))
    half = 0.5 * camera.exposure_s
    begin = np.interp(seen.middle_s - half, motion.time_s, integral)
    end = np.interp(seen.middle_s + half, motion.time_s, integral)
    mean = (end - begin) / camera.exposure_s
    noise = camera.noise_px * coloured(luck, len(mean), camera.colour)
    return np.asarray(-camera.scale_px_per_m * mean + camera.offset_px + noise)


def free_spans(case: Case) -> list[tuple[float, float]]:
    """From the end of each event to the beginning of the next. A move ends when the joint's lag has died away."""
    settle_s = case.joint.dead_time_s + 5.0 / (2.0 * np.pi * case.joint.bandwidth_hz)
    begins = [0.0] if case.swinging_m > 0.0 else []
    spans = []
    for event in case.events:
        if begins:
            spans.append((begins[-1], event.at_s - 0.01))
        begins.append(event.end_s + (settle_s if event.kind == "move" else 0.0))
        if event.kind == "strike":
            begins[-1] = event.at_s
    spans.append((begins[-1], case.duration_s - 0.011))
    return [(round(a, 4), round(b, 4)) for a, b in spans if b - a >= _SHORTEST_SWING_S]


def _is_seen(case: Case, motion: Motion, begin_s: float, end_s: float) -> bool:
    inside = (motion.time_s >= begin_s) & (motion.time_s < min(end_s, begin_s + 1.5))
    return bool(np.max(np.abs(motion.deflection_m[inside])) >= _LEAST_SEEN * case.noise_m)
