"""What a case's sensors and clocks say without noise, in units of their noise: one long vector.

Each channel is divided by its noise; the frames' arrival is whitened under its law, a slow Gauss-Markov wander plus
white jitter plus the wait for the next tick, by the innovations of its Kalman filter.
"""

import numpy as np
from numpy.typing import NDArray

from tests.hidden_world.feeler import converted
from tests.hidden_world.rig import TICK_S, Eye, Rig
from tests.hidden_world.world import Case, Clean

Array = NDArray[np.float64]
_STAMP_S = 5e-5


def whitened(case: Case, clean: Clean) -> Array:
    """Every kept channel in units of its noise, one after the other, in an order that depends on the case alone."""
    return np.concatenate(list(by_channel(case, clean).values()))


def by_channel(case: Case, clean: Clean) -> dict[str, Array]:
    """The same under the channels' names; `arrival` and `stamp` are the frames' clocks."""
    rig, kept = case.rig, case.kept
    ticks = len(clean.command)
    parts = {}
    if "acceleration" in kept:
        parts["acceleration"] = converted(rig, case.effects, clean.acceleration) / acceleration_noise(rig)
    if "angle" in kept:
        noise = float(np.hypot(rig.joint.encoder_noise, rig.joint.encoder_step / 12.0**0.5))
        parts["angle"] = clean.angle / noise
    if "speed" in kept:
        parts["speed"] = clean.speed / rig.joint.rate_noise
    if "gauge" in kept:
        parts["gauge"] = clean.gauge / rig.gauge_noise
    if "image" in kept:
        rows = slice(2, max(int((ticks * TICK_S - 0.3) * rig.eye.rate), 2))  # those that surely arrive within
        parts["image"] = clean.image[rows] / image_noise(case, clean)[rows]
        parts["arrival"] = _innovations(rig.eye, _read(case, clean)[rows])
        if "stamp" in kept and rig.eye.stamped:
            parts["stamp"] = _stamped(case, clean)[rows] / _STAMP_S
    return parts


def acceleration_noise(rig: Rig) -> float:
    """m/s^2, with what rounding adds."""
    return float(np.hypot(rig.feeler.hiss, rig.feeler.grain / 12.0**0.5))


def image_noise(case: Case, clean: Clean) -> Array:
    """px, of each image. When an exposure is triggered, its instant is known to the tick only, which is noise too
    while the joint moves; its planned speed, seen as its owner believes, stands for what the image does, so that
    neither an effect nor a refitted scale changes the weights: a scale that did would leave of itself what it made of
    the weights, and an effect that looks like a scale would seem to show."""
    eye, assumed = case.rig.eye, case.assumed
    if eye.free:
        return np.full(len(clean.image), eye.px_noise)
    ticks = np.minimum((clean.frames.middle / TICK_S).astype(int), len(clean.reference) - 1)
    speed = assumed.eye.px_per_m * assumed.reach * clean.reference[ticks]
    return np.asarray(np.hypot(eye.px_noise, speed * TICK_S / 12.0**0.5))


def _read(case: Case, clean: Clean) -> Array:
    """Arrival, before it waits for a tick, on the clock as it reads after any step."""
    arrival = clean.frames.arrival.copy()
    for e in case.effects:
        if e.name == "clock_step" and e.kind != "stamp":
            arrival += e["step_s"] * (clean.frames.arrival >= e["onset_s"])
    return arrival


def _stamped(case: Case, clean: Clean) -> Array:
    stamp = clean.frames.stamp.copy()
    for e in case.effects:
        if e.name == "clock_step" and e.kind == "stamp":
            stamp += e["step_s"] * (clean.frames.arrival >= e["onset_s"])
    return stamp


def _innovations(eye: Eye, values: Array) -> Array:
    """The values minus what their past foretells under the law of the delay, over the innovation's deviation."""
    keep = float(np.exp(-1.0 / (eye.rate * eye.slow_s)))
    slow = eye.slow_part * eye.late_spread_s**2
    quick = (1.0 - eye.slow_part) * eye.late_spread_s**2 + TICK_S**2 / 12.0
    state, variance = 0.0, slow
    out = np.empty(len(values))
    for k, value in enumerate(values.tolist()):
        total = variance + quick
        error = value - state
        out[k] = error / total**0.5
        weight = variance / total
        state = keep * (state + weight * error)
        variance = keep * keep * variance * (1.0 - weight) + (1.0 - keep * keep) * slow
    return out
