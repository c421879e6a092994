"""The accelerometer: from the tip's motion on the fine grid to a reading at every tick."""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from tests.hidden_world.effects import Effect, rough_ramp, wander
from tests.hidden_world.rig import FINE, STEP_S, TICK_S, Rig

Array = NDArray[np.float64]


@dataclass
class _Reading:
    rig: Rig
    rows: Array
    fine: Array
    """The tip's acceleration on the fine grid, m/s^2."""
    time: Array
    """The ticks, s."""
    lateness_s: float
    gain: Array
    added: Array
    scale_m: float


def felt(rig: Rig, effects: tuple[Effect, ...], rows: Array, scale_m: float) -> Array:
    """What reaches the converter at every tick, m/s^2, without noise."""
    ticks = (len(rows) - 1) // FINE
    reading = _Reading(
        rig,
        rows,
        rows[:, 7],
        np.asarray(np.arange(ticks) * TICK_S, dtype=np.float64),
        rig.feeler.lateness_s,
        np.ones(ticks),
        np.zeros(ticks),
        scale_m,
    )
    for effect in effects:
        if effect.name in _CHANGES:
            _CHANGES[effect.name](reading, effect)
    grid = np.arange(len(rows)) * STEP_S
    late = np.interp(reading.time - reading.lateness_s, grid, reading.fine)
    out: Array = rig.feeler.gain * late * reading.gain + rig.feeler.bias + reading.added
    return out


def converted(rig: Rig, effects: tuple[Effect, ...], signal: Array) -> Array:
    """The converter: its range, softly bounded where clipping is hidden. Rounding comes with the noise."""
    out = np.clip(signal, -rig.feeler.limit, rig.feeler.limit)
    for effect in effects:
        if effect.name == "accelerometer_clipping":
            limit = effect["range_m_s2"]
            if effect.detail == 0.0:
                out = np.clip(out, -limit, limit)
            else:
                power = 40.0 / effect.detail
                out = out / (1.0 + np.abs(out / limit) ** power) ** (1.0 / power)
    return np.asarray(out)


def spikes(effects: tuple[Effect, ...], ticks: int) -> Array:
    """Impulses of impulse_noise, m/s^2: random instants, signs and sizes; a fifth last two samples."""
    out = np.zeros(ticks)
    for effect in effects:
        if effect.name == "impulse_noise":
            random = effect.chance()
            draw = random.random(ticks)
            sign = np.where(random.random(ticks) < 0.5, -1.0, 1.0)
            size = 1.0 + 0.25 * effect.detail * (random.gamma(4.0, 0.5, ticks) - 2.0)
            twice = random.random(ticks) < 0.2 * effect.detail
            hit = draw < effect["rate_hz"] * TICK_S
            pulse = np.where(hit, sign * size * effect["amplitude_m_s2"], 0.0)
            out += pulse
            out[1:] += np.where(twice[:-1], 0.5 * pulse[:-1], 0.0)
    return out


def _bias(r: _Reading, e: Effect) -> None:
    r.added += rough_ramp(e, r.time, e["rate_m_s3"])


def _sensitivity(r: _Reading, e: Effect) -> None:
    r.gain *= 1.0 + rough_ramp(e, r.time, e["rate_per_s"])


def _lag(r: _Reading, e: Effect) -> None:
    """Plain: a pure delay. Rough: the extra lateness is that of two equal first-order filters."""
    extra = (e["delay_s"] - r.rig.feeler.lateness_s) * min(e.detail, 1.0)
    if extra <= 0.0:
        r.lateness_s = e["delay_s"]
        return
    r.lateness_s = e["delay_s"] - extra
    keep = float(np.exp(-STEP_S / (0.5 * extra)))
    # exact hold, and half a step earlier on average: the group delay of each filter is 0.5 extra + 0.5 STEP_S
    once = lfilter([1.0 - keep], [1.0, -keep], r.fine - r.fine[0]) + r.fine[0]
    r.fine = np.asarray(lfilter([1.0 - keep], [1.0, -keep], once - once[0]) + once[0])


def _gravity(r: _Reading, e: Effect) -> None:
    slopes = r.rig.slopes
    tilt = r.rows[::FINE, 6] + slopes[0] * r.rows[::FINE, 2]
    if len(slopes) > 1:
        tilt = tilt + slopes[1] * r.rows[::FINE, 4]
    tilt = tilt[: len(r.time)]
    r.added += e["gain_m_s2_per_rad"] * (tilt + e.detail * (np.sin(tilt) - tilt))


def _hum(r: _Reading, e: Effect) -> None:
    random = e.chance()
    start, third = random.uniform(0.0, 2.0 * pi, 2)
    halves = np.arange(0.0, r.time[-1] + 1.0, 0.5)
    stray = np.interp(r.time, halves, wander(random, len(halves), 8.0, 0.5))
    turn = 2.0 * pi * e["frequency_hz"] * r.time + start + 0.3 * e.detail * stray
    r.added += e["amplitude_m_s2"] * (np.sin(turn) + 0.15 * e.detail * np.sin(3.0 * turn + third))


def _wandering_gain(r: _Reading, e: Effect) -> None:
    r.gain *= 1.0 + e["amount"] * wander(e.chance(), len(r.time), 1.2, TICK_S)


def _gear_mesh(r: _Reading, e: Effect) -> None:
    """Teeth meet faster than half the sampling rate: the tone folds down, up and down with the joint's speed."""
    angle, speed = r.rows[::FINE, 0][: len(r.time)], r.rows[::FINE, 1][: len(r.time)]
    r.added += e["amount"] * np.minimum(np.abs(speed) / 0.05, 1.0) * np.sin(e["teeth_per_rad"] * angle)


def _bursts(r: _Reading, e: Effect) -> None:
    """Noise about 35 Hz that comes and goes."""
    noise = np.asarray(e.chance().standard_normal(len(r.time)))
    pole = np.exp(2.0 * pi * TICK_S * 35.0 * (-0.1 + 1j))
    noise = lfilter([1.0], [1.0, -2.0 * pole.real, abs(pole) ** 2], noise)
    on = np.zeros(len(r.time))
    for begin, lasts, size in burst_times(e, float(r.time[-1])):
        on[(r.time >= begin) & (r.time < begin + lasts)] = size
    r.added += e["amount"] * r.rig.feeler.hiss * on * noise / np.std(noise)


def burst_times(e: Effect, until_s: float) -> list[tuple[float, float, float]]:
    """(beginning, duration, size) of each burst of noise."""
    random = e.chance(1)
    out, t = [], float(random.exponential(2.0))
    while t < until_s:
        lasts = float(random.uniform(0.2, 1.2))
        out.append((t, lasts, float(random.uniform(0.5, 1.5))))
        t += lasts + float(random.exponential(2.5))
    return out


def second_axis(rig: Rig, effect: Effect, ticks: int, scale_m: float) -> tuple[Array, Array]:
    """Position (m) and acceleration of a second, unmeasured axis at the ticks: jerks at random, ringing, drifting."""
    random = effect.chance()
    w = 2.0 * pi * rig.bends[0].hertz * effect["ratio"]
    kicks = np.where(random.random(ticks) < 0.7 * TICK_S, random.standard_normal(ticks), 0.0)
    pole = np.exp(TICK_S * w * (-0.03 + 1j))
    ringing = lfilter([0.0, abs(pole) * np.sin(w * TICK_S)], [1.0, -2.0 * pole.real, abs(pole) ** 2], kicks)
    slow = wander(random, ticks, 3.0, TICK_S)
    slow = np.asarray(lfilter([0.004], [1.0, -0.996], slow - slow[0]))
    place = scale_m * (ringing + 0.5 * slow)
    acceleration = np.gradient(np.gradient(place, TICK_S), TICK_S)
    return place, acceleration


def _second_axis(r: _Reading, e: Effect) -> None:
    r.added += r.rig.feeler.gain * e["amount"] * second_axis(r.rig, e, len(r.time), r.scale_m)[1]


_CHANGES: dict[str, Callable[[_Reading, Effect], None]] = {
    "accelerometer_bias_drift": _bias,
    "accelerometer_sensitivity_drift": _sensitivity,
    "accelerometer_lag": _lag,
    "gravity_leakage": _gravity,
    "mains_hum": _hum,
    "wandering_gain": _wandering_gain,
    "aliased_gear_mesh": _gear_mesh,
    "correlated_bursts": _bursts,
    "second_axis": _second_axis,
}
