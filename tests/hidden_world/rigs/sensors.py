"""Accelerometer and encoder, with what effects do to them."""

import numpy as np
from scipy.signal import lfilter

from tests.hidden_world.rigs.course import course, poisson
from tests.hidden_world.rigs.motion import Motion
from tests.hidden_world.rigs.rig import FINE, STEP_S, TICK_S, Effect, Rig, Values, luck

GRAVITY_M_S2 = 9.80665


def coloured(chance: np.random.Generator, count: int, colour: float) -> Values:
    """Noise of unit variance, each value correlated with the next by `colour`."""
    white = chance.normal(0.0, np.sqrt(1.0 - colour * colour), count)
    white[0] /= np.sqrt(1.0 - colour * colour)
    return np.asarray(lfilter([1.0], [1.0, -colour], white))


def acceleration(rig: Rig, motion: Motion, effects: tuple[Effect, ...], noise: bool = True) -> Values:
    """What the accelerometer says at each cycle. noise: its own; spikes of impulse_noise are an effect."""
    sensor = rig.accelerometer
    assert sensor is not None
    mine = {e.cause: e for e in effects}
    tip = _lagged(motion.tip_m_s2, mine.get("accelerometer_lag"))
    true = tip[::FINE][: rig.cycles]
    t = np.arange(rig.cycles) * TICK_S
    out = sensor.scale * true
    if e := mine.get("accelerometer_sensitivity_drift"):
        out = out * (1.0 + e.sign * e.size * course(e.form, t, e.onset_s, e.seed))
    if e := mine.get("accelerometer_gain_nonlinear"):
        usual = max(float(np.sqrt(np.mean(true**2))), 1e-9)
        bent = np.abs(out) if e.form == "even" else np.minimum(np.abs(out), 6.0 * usual) ** 2 / usual
        out = out + e.sign * e.size * bent * (out / usual if e.form == "even" else np.sign(out))
    out = out + sensor.bias_m_s2
    if e := mine.get("accelerometer_bias_drift"):
        out = out + e.sign * e.size * course(e.form, t, e.onset_s, e.seed)
    if e := mine.get("gravity_leakage"):
        out = out + e.sign * e.size * _leak(motion, e.form)[::FINE][: rig.cycles]
    if e := mine.get("mains_hum"):
        out = out + _hum(e, t)
    if noise:
        out = out + sensor.noise_m_s2 * coloured(luck(rig.seed, 41), rig.cycles, sensor.colour)
    if e := mine.get("impulse_noise"):
        out = out + _spikes(e, rig)
    limit = sensor.range_m_s2
    if e := mine.get("accelerometer_clipping"):
        return clipped(out, e.extras["peak_m_s2"] / (1.0 + e.size), e)
    return np.clip(out, -limit, limit)


def clipped(x: Values, limit: float, effect: Effect) -> Values:
    """Hard, with a soft knee, or on one side."""
    if effect.form == "soft":
        y = np.abs(x) / limit
        return np.asarray(np.sign(x) * limit * np.where(y < 0.9, y, 0.9 + 0.1 * np.tanh((y - 0.9) / 0.1)))
    if effect.form == "one_side":
        return np.asarray(np.minimum(x, limit) if effect.sign > 0 else np.maximum(x, -limit))
    return np.clip(x, -limit, limit)


def _lagged(tip: Values, effect: Effect | None) -> Values:
    if effect is None:
        return tip
    if effect.form == "delay":
        steps = effect.size / STEP_S
        at = np.arange(len(tip)) - steps
        return np.interp(at, np.arange(len(tip)), tip)
    count = 2 if effect.form == "second_order" else 1
    keep = float(np.exp(-STEP_S / (effect.size / count)))
    for _ in range(count):
        tip = np.asarray(lfilter([1.0 - keep], [1.0, -keep], tip))
    return tip


def _leak(motion: Motion, form: str) -> Values:
    if form == "sine":
        return np.asarray(np.sin(motion.link_rad))
    if form == "sine_with_slope":
        return np.asarray(np.sin(motion.link_rad + motion.slope_rad))
    return motion.link_rad


def _hum(effect: Effect, t: Values) -> Values:
    f, chance = effect.extras["frequency_hz"], luck(effect.seed, 42)
    phase = 2.0 * np.pi * f * t + chance.uniform(0.0, 2.0 * np.pi)
    wave = np.sin(phase)
    if effect.form == "third_harmonic":
        wave = wave + 0.35 * np.sin(3.0 * phase + chance.uniform(0.0, 2.0 * np.pi))
    if effect.form == "swelling":
        wave = wave * (1.0 + 0.4 * np.sin(2.0 * np.pi * t / 7.0))
    return np.asarray(effect.size * wave * (t >= effect.onset_s))


def _spikes(effect: Effect, rig: Rig) -> Values:
    chance = luck(effect.seed, 43)
    out = np.zeros(rig.cycles)
    at = (poisson(effect.extras["rate_hz"], rig.duration_s, chance, effect.onset_s) / TICK_S).astype(int)
    sizes = effect.size * chance.choice([-1.0, 1.0], len(at))
    if effect.form != "equal":
        sizes = sizes * chance.exponential(1.0, len(at))
    for k, size in zip(at.tolist(), sizes.tolist(), strict=True):
        out[k] += size
        if effect.form == "two_samples" and k + 1 < len(out):
            out[k + 1] += 0.5 * size
    return out


def encoder(rig: Rig, motion: Motion, noise: bool = True) -> tuple[Values, Values]:
    """Position and speed of the joint at each cycle."""
    sensor = rig.encoder
    assert sensor is not None
    position = (motion.motor_rad if sensor.at_motor else motion.link_rad)[::FINE][: rig.cycles]
    speed = (motion.motor_rad_s if sensor.at_motor else motion.link_rad_s)[::FINE][: rig.cycles]
    if not noise:
        return position, speed
    position = position + sensor.noise_rad * luck(rig.seed, 44).normal(size=rig.cycles)
    if sensor.quantum_rad > 0.0:
        position = np.round(position / sensor.quantum_rad) * sensor.quantum_rad
    return position, speed + sensor.speed_noise_rad_s * luck(rig.seed, 45).normal(size=rig.cycles)
