"""When images are exposed and when they are read, and what is seen on them, with what effects do to both."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tests.hidden_world.rigs.course import course, poisson, wander
from tests.hidden_world.rigs.motion import Motion
from tests.hidden_world.rigs.rig import STEP_S, TICK_S, Effect, Rig, Values, luck
from tests.hidden_world.rigs.sensors import coloured

_TRIGGER_S = 0.0003
_LAST_S = 0.4  # before the end, no more exposures


@dataclass(frozen=True)
class Images:
    """Of each image that is read, shape (images,). index: of its exposure; content: of the exposure that it shows;
    number: as the camera or the driver counts; middle_s: of the exposure that it shows, truly; counted_s: of the
    exposure of its index, as a sound camera's count or the request dates it; stamp_s: NaN where there is none."""

    index: NDArray[np.int64]
    content: NDArray[np.int64]
    number: NDArray[np.int64]
    middle_s: Values
    counted_s: Values
    received_s: Values
    started_s: Values
    stamp_s: Values


def images(rig: Rig, effects: tuple[Effect, ...]) -> Images:
    """All images of a rig that are read before it ends."""
    camera, law, chance = rig.camera, rig.arrival, luck(rig.seed, 51)
    mine = {e.cause: e for e in effects}
    count = int((rig.duration_s - _LAST_S) * camera.frame_rate_hz)
    index = np.arange(count)
    period = 1.0 / camera.frame_rate_hz
    first = float(chance.uniform(0.01, 0.05))
    if camera.triggered:
        asked = np.ceil((first + index * period) / TICK_S) * TICK_S
        start = nominal = asked + _TRIGGER_S
    else:
        nominal = first + index * period
        start = first + index * period
        if e := mine.get("camera_clock_skew"):
            start = start + 1e-6 * e.sign * e.size * _skewed(e, index * period)
        asked = start
    middle = start + 0.5 * camera.exposure_s
    ready = middle + _lateness(rig, index * period, mine)
    if (
        e := mine.get("stale_frame_buffer")
    ) and e.form == "queue":  # one stall, after which the queue stays longer
        ready = ready + round(e.size) * period * (ready >= e.onset_s)
    lost = _lost(rig, count, mine)
    received = _in_order(_read(ready, law.received_quantum_s), lost, law.received_quantum_s)
    stamp = np.full(count, np.nan)
    if camera.stamped:
        jitter = camera.stamp_jitter_s * luck(rig.seed, 52).normal(size=count)
        on_clock = nominal + 0.5 * camera.exposure_s + jitter
        stamp = camera.stamp_offset_s + (1.0 + 1e-6 * camera.stamp_ppm) * on_clock
    started = _started(rig, asked, received)
    content, number = index.copy(), index.copy()
    stale = mine.get("stale_frame_buffer")
    if stale and stale.form != "queue":
        content = np.where(received >= stale.onset_s, np.maximum(index - round(stale.size), 0), index)
    keep = ~lost & (received < rig.duration_s - 2.0 * TICK_S)
    if not camera.counts_exposures:
        number = np.cumsum(keep) - 1
    if stale and stale.form == "with_stamp":
        stamp = stamp[content]
    received, started, stamp = _stepped(mine.get("clock_step"), received, started, stamp)
    if camera.stamped:
        stamp = np.round(stamp / camera.stamp_quantum_s) * camera.stamp_quantum_s
    return Images(
        index[keep],
        content[keep],
        number[keep],
        middle[content][keep],
        nominal[keep] + 0.5 * camera.exposure_s,
        received[keep],
        started[keep],
        stamp[keep],
    )


def _skewed(effect: Effect, t: Values) -> Values:
    """s, of which a share of size ppm is gained or lost."""
    if effect.form == "warming":  # the rate changes by as much again as the clock warms up
        tau = 0.3 * float(t[-1])
        return np.asarray(t + tau * (1.0 - np.exp(-t / tau)) * 0.5)
    return np.maximum(t - effect.onset_s, 0.0) if effect.form == "from_onset" else t


def _lateness(rig: Rig, t: Values, mine: dict[str, Effect]) -> Values:
    law, chance, count = rig.arrival, luck(rig.seed, 53), len(t)
    slow = law.std_s * np.sqrt(law.wander_share) * wander(t, law.wander_time_s, chance)
    fast = law.std_s * np.sqrt(1.0 - law.wander_share)
    if law.one_sided:
        jitter = fast * (chance.gamma(2.0, 1.0, count) - 2.0) / np.sqrt(2.0)
    else:
        jitter = fast * chance.normal(size=count)
    late = law.mean_s + slow + jitter
    if e := mine.get("delay_drift"):
        late = late + e.sign * e.size * course(e.form, t, e.onset_s, e.seed)
    if e := mine.get("delay_bursts"):
        late = late + _bursts(e, rig, t)
    least = 0.5 * rig.camera.exposure_s + rig.camera.readout_s + 0.002
    return np.maximum(late, least)


def _bursts(effect: Effect, rig: Rig, t: Values) -> Values:
    chance = luck(effect.seed, 54)
    out = np.zeros(len(t))
    for at in poisson(effect.extras["rate_hz"], rig.duration_s - 1.0, chance, effect.onset_s):
        lasting, depth = effect.extras["duration_s"], effect.size
        if effect.form != "equal":
            lasting, depth = lasting * chance.gamma(3.0, 1.0 / 3.0), depth * chance.gamma(4.0, 1.0 / 4.0)
        since = t - at
        shape = np.ones(len(t))
        if effect.form == "draining":  # a stall, after which the queue drains
            shape = np.clip(1.0 - since / max(lasting, 1e-3), 0.0, 1.0)
        out = np.maximum(out, np.where((since >= 0.0) & (since < lasting), depth * shape, 0.0))
    return out


def _lost(rig: Rig, count: int, mine: dict[str, Effect]) -> NDArray[np.bool_]:
    e = mine.get("frame_drops")
    if e is None:
        return np.zeros(count, bool)
    chance = luck(e.seed, 55)
    t = np.arange(count) / rig.camera.frame_rate_hz
    if e.form == "single":
        return np.asarray((chance.random(count) < e.size) & (t >= e.onset_s))
    longest = float(e.extras["run"])
    lost = np.zeros(count, bool)
    for k in np.flatnonzero((chance.random(count) < e.size / longest) & (t >= e.onset_s)):
        lost[k : k + 1 + int(chance.poisson(longest - 1.0))] = True
    return lost


def _read(ready: Values, quantum_s: float) -> Values:
    return np.asarray(np.ceil(ready / quantum_s - 1e-9) * quantum_s)


def _in_order(ready: Values, lost: NDArray[np.bool_], quantum_s: float) -> Values:
    """One after another, in their order, a quantum apart at the least; what is lost holds up nobody."""
    out, before = ready.copy(), -1.0
    gap = max(quantum_s, TICK_S)
    for k in range(len(out)):
        if not lost[k]:
            out[k] = before = max(ready[k], before + gap)
    return out


def _started(rig: Rig, asked: Values, received: Values) -> Values:
    """n_i: the cycle of the request; of a free camera that, or the cycle at which the image was there."""
    chance, count, camera = luck(rig.seed, 56), len(asked), rig.camera
    if camera.triggered:
        return asked
    if rig.arrival.grab == "next":
        at = asked - chance.uniform(0.001, 0.5 / camera.frame_rate_hz, count)
    else:
        at = asked + camera.exposure_s + camera.readout_s + chance.gamma(2.0, 0.001, count)
    at = np.minimum(np.maximum(at, 0.0), received - TICK_S)
    return np.asarray(np.floor(np.maximum.accumulate(at) / TICK_S) * TICK_S)


def _stepped(
    effect: Effect | None, received: Values, started: Values, stamp: Values
) -> tuple[Values, Values, Values]:
    if effect is None:
        return received, started, stamp
    step = effect.sign * effect.size * (received >= effect.onset_s)
    if effect.form == "camera":
        return received, started, stamp + step
    step = np.round(step / TICK_S) * TICK_S
    return received + step, started + step, stamp


def displacement(
    rig: Rig, motion: Motion, seen: Images, effects: tuple[Effect, ...], noise: bool = True
) -> Values:
    """The mean over each exposure, shape (images,), px."""
    camera, mine = rig.camera, {e.cause: e for e in effects}
    t, exposures = motion.time_s, int(np.max(seen.index)) + 1
    px = -camera.scale_px_per_m * motion.s_m
    if e := mine.get("image_scale_drift"):
        px = px * (1.0 + e.sign * e.size * course(e.form, t, e.onset_s, e.seed))
    if camera.rotation_px_per_rad:
        px = px - camera.rotation_px_per_rad * (motion.link_rad + motion.slope_rad)
    if e := mine.get("camera_tilt_coupling"):
        angle = motion.link_rad + motion.slope_rad
        angle = {"angle": angle, "sine": np.sin(angle), "joint_alone": motion.link_rad}[e.form]
        px = px - e.sign * e.size * angle
    for cause, course_m in (("torsion_in_image", motion.side_m), ("cross_axis_coupling", motion.side_m)):
        if e := mine.get(cause):
            leak = e.size if cause == "torsion_in_image" else e.extras["leak"]
            px = px + camera.scale_px_per_m * leak * course_m
    if e := mine.get("loose_camera_mount"):
        px = px + camera.scale_px_per_m * e.size * motion.mount_m
    integral = np.concatenate(([0.0], np.cumsum(0.5 * (px[1:] + px[:-1]) * STEP_S)))
    half = 0.5 * camera.exposure_s
    mean = (np.interp(seen.middle_s + half, t, integral) - np.interp(seen.middle_s - half, t, integral)) / (
        2.0 * half
    )
    mean = mean + camera.offset_px
    if e := mine.get("lens_distortion"):
        mean = _distorted(mean, e)
    if e := mine.get("tracking_drift"):
        mean = mean + e.sign * e.size * _drift(e, motion, seen.middle_s)
    if noise:
        mean = mean + (camera.noise_px * coloured(luck(rig.seed, 57), exposures, camera.colour))[seen.content]
    return np.asarray(mean)


def _distorted(px: Values, effect: Effect) -> Values:
    """size: relative change of the scale at extras["edge_px"]."""
    centre, edge = effect.extras.get("centre_px", 0.0), effect.extras["edge_px"]
    x = (px - centre) / edge
    grown = effect.sign * effect.size * x**2
    if effect.form == "fifth_order":
        grown = grown + 0.3 * effect.sign * effect.size * x**4
    return np.asarray(centre + edge * x * (1.0 + grown))


def _drift(effect: Effect, motion: Motion, at_s: Values) -> Values:
    t = motion.time_s[::100]
    speed = np.abs(np.gradient(motion.s_m[::100], t))
    path = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(t))))
    return np.interp(at_s, t, course(effect.form, t, effect.onset_s, effect.seed, path))
