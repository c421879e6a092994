"""When frames are exposed, handed over and read, and what the clocks say about it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tests.hidden_world.effects import Effect, rough_ramp, wander
from tests.hidden_world.rig import TICK_S, Rig

Array = NDArray[np.float64]
_TRANSFER_S = 0.001
_STAMP_JITTER_S = 2e-5
_TRIGGER_S = 0.0003


@dataclass
class Frames:
    """One row an image, in the order of arrival, before any is lost.

    middle: mid-exposure of what it shows; arrival: when it is ready to be read; asked: when it was asked for
    (triggered) or NaN; stamp: the camera's own; number: what its counter says. s.
    """

    middle: Array
    arrival: Array
    asked: Array
    stamp: Array
    number: NDArray[np.int64]
    lost: NDArray[np.bool_]


def frames(rig: Rig, effects: tuple[Effect, ...], duration_s: float, seed: int) -> Frames:
    """The instants of every image of a recording; the random part depends on the seed alone, not on the effects."""
    eye = rig.eye
    count = int(duration_s * eye.rate)
    random = np.random.default_rng((seed, 11))
    scheduling = random.uniform(0.0, TICK_S, count)
    slow = wander(random, count, eye.slow_s, 1.0 / eye.rate)
    quick = random.standard_normal(count)
    jitter = random.standard_normal(count)
    index = np.arange(count)
    skew = sum(
        e["skew_ppm"] * 1e-6 * _skew_shape(e, index / eye.rate)
        for e in effects
        if e.name == "camera_clock_skew"
    )
    asked = np.full(count, np.nan)
    if eye.free:
        start = eye.phase_s + (index + np.asarray(skew) * index) / eye.rate
    else:
        asked = eye.phase_s + index / eye.rate + scheduling
        start = asked + _TRIGGER_S
    middle = start + 0.5 * eye.open_s
    delay: Array = (
        eye.late_s
        - 0.5 * TICK_S
        + eye.late_spread_s * (np.sqrt(eye.slow_part) * slow + np.sqrt(1.0 - eye.slow_part) * quick)
    )
    for e in effects:
        if e.name == "delay_drift":
            delay = delay + rough_ramp(e, middle, e["rate_s_per_s"])
        elif e.name == "delay_bursts":
            delay = delay + burst_delay(e, middle)
    lost = np.zeros(count, dtype=bool)
    arrival = middle + np.maximum(delay, 0.5 * eye.open_s + _TRANSFER_S)
    shown = index.copy()
    for e in effects:
        if e.name == "stale_frame_buffer":
            older = round(e["frames"])
            after = middle > e["onset_s"]
            if eye.counts_exposures:  # the queue stalls once, and stays longer by that many frames
                arrival = arrival + np.where(after, older / eye.rate, 0.0)
            else:  # the driver hands over the buffer filled that many frames ago
                shown = np.where(after, np.maximum(index - older, 0), index)
        elif e.name == "frame_drops":
            lost |= _lost(e, count)
    slack = _TRANSFER_S * index
    arrival = np.maximum.accumulate(arrival - slack) + slack  # in order, one after the other
    stamp = (middle[shown] + eye.stamp_offset_s) * (1.0 + 1e-6 * eye.stamp_ppm) + _STAMP_JITTER_S * jitter
    return Frames(middle[shown], arrival, asked, stamp, index, lost)


def read_at(arrival: Array) -> Array:
    """The tick at which each is read: the first one after its arrival, one image a tick."""
    ticks = np.asarray(np.ceil(arrival / TICK_S - 1e-9), dtype=np.float64)
    index = np.arange(len(ticks))
    return np.asarray((np.maximum.accumulate(ticks - index) + index) * TICK_S, dtype=np.float64)


def _skew_shape(e: Effect, time: Array) -> Array:
    """Rough: the crystal warms up, so that its rate strays by a twentieth."""
    if e.detail == 0.0 or len(time) < 2:
        return np.ones(len(time))
    span = float(time[-1])
    return np.asarray(1.0 + 0.05 * np.exp(-time / (0.4 * span)) - 0.02)


def burst_delay(e: Effect, middle: Array) -> Array:
    """Extra delay of each frame, s. Rough: bursts of random length, each with its own delay."""
    out = np.zeros(len(middle))
    for begin, lasts, late in bursts(e, float(middle[-1]) if len(middle) else 0.0):
        out[(middle >= begin) & (middle < begin + lasts)] = late
    return out


def bursts(e: Effect, until_s: float) -> list[tuple[float, float, float]]:
    """(beginning, duration, extra delay) of each burst, s."""
    random, t = e.chance(), 0.0
    out: list[tuple[float, float, float]] = []
    while True:
        gap, stretch, swell = random.exponential(1.0), random.gamma(6.0, 1.0 / 6.0), random.uniform(0.8, 1.2)
        t += gap / e["rate_hz"]
        if t > until_s:
            return out
        lasts = e["duration_s"] * (1.0 + e.detail * (stretch - 1.0))
        out.append((t, lasts, e["delay_s"] * (1.0 + e.detail * (swell - 1.0))))
        t += lasts


def _lost(e: Effect, count: int) -> NDArray[np.bool_]:
    """Rough: losses come in runs of 1.5 frames on average; the fraction lost is the same."""
    random, fraction = e.chance(), e["fraction"]
    draw = random.random(count)
    if e.detail == 0.0:
        return np.asarray(draw < fraction)
    stay = 1.0 / 3.0
    enter = min(fraction * (1.0 - stay) / (1.0 - fraction), 1.0)
    out, now = np.zeros(count, dtype=bool), False
    for k in range(count):
        now = bool(draw[k] < (stay if now else enter))
        out[k] = now
    return out
