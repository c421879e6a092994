"""A start for the calibration that owes nothing to the model: signs, scales, delay, frequency may all be wrong in it.

In this order, each from what those before it have given:

    drive            the joint's report under its commands: bandwidth and dead time
    frequency, decay the free vibration while the joint stands (stillarm.diagnosis.calibration.ring_down)
    participation, signs and scales
                     each channel is linear in the joint's rigid part and in the vibration that a unit of participation
                     would have; the capture delay is that of a grid at which the image fits best
    frame rate       arrivals against the frames' counter

What is taken from the model as it is: length, the drive's limits, the accelerometer's range and filter, exposure.
"""

from dataclasses import dataclass
from math import sqrt

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from stillarm.common.files.model import Model
from stillarm.diagnosis.calibration.ring_down import Stretch, peaks, ringing
from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.data.robust import white_noise
from stillarm.diagnosis.physics.world import World

Array = NDArray[np.float64]
Span = tuple[float, float]
_STILL_RAD_S = 1e-6
_SETTLE_S = 0.25  # after a command's end, until the joint stands
_SHORTEST_S = 0.8
_DELAYS_S = np.arange(0.0, 0.3, 0.002)
_BEFORE_S = 0.2


@dataclass(frozen=True)
class Start:
    """A model to begin with; signal: ringing over noise, power per sample. moved: whether the joint gave the scales."""

    model: Model
    signal: float
    moved: bool


def commanded(measured: Measured) -> NDArray[np.bool_]:
    """Whether the joint was told to move at all, at each cycle, (cycles,)."""
    return np.asarray(np.abs(np.nan_to_num(measured.command)) > _STILL_RAD_S)


def still_spans(measured: Measured, settle_s: float = _SETTLE_S) -> list[Span]:
    """From and to, s, where the joint was told to stand, and does."""
    moving = commanded(measured)
    edges = np.flatnonzero(np.diff(np.concatenate(([True], moving, [True]))))
    spans = []
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        begin = first * measured.cycle_s + (settle_s if first else 0.0)
        if last * measured.cycle_s - begin >= _SHORTEST_S:
            spans.append((begin, last * measured.cycle_s))
    return spans


def moving_spans(measured: Measured, after_s: float) -> list[Span]:
    """Windows about the moves, `after_s` of free vibration with each; those that touch are one."""
    moving = np.flatnonzero(commanded(measured))
    if not len(moving):
        return []
    gaps = np.flatnonzero(np.diff(moving) * measured.cycle_s > _BEFORE_S)
    first = moving[np.concatenate(([0], gaps + 1))] * measured.cycle_s
    last = moving[np.concatenate((gaps, [len(moving) - 1]))] * measured.cycle_s
    spans: list[Span] = []
    for begin, end in zip(first - _BEFORE_S, last + after_s, strict=True):
        if spans and begin <= spans[-1][1]:
            spans[-1] = (spans[-1][0], float(end))
        else:
            spans.append((float(begin), float(end)))
    return [(max(a, 0.0), min(b, measured.duration_s)) for a, b in spans]


def start_values(measured: Measured, model: Model) -> Start | None:
    """Work it all out; None where the joint never stood long enough to ring."""
    model = _with_frame_rate(measured, model)
    spans = still_spans(measured)
    if not spans:
        return None
    model = _with_drive(measured, model)
    world = World(measured, model)
    stretches = _stretches(world, spans)
    if not stretches:
        return None
    found = [ringing(stretches, hz) for hz in peaks(stretches)[:3]]
    if not found:
        return None
    first = max(found, key=lambda one: one.power)
    modes = [
        msgspec.structs.replace(
            model.arm.modes[0], frequency_hz=first.frequency_hz, damping_ratio=first.damping_ratio
        ),
        *model.arm.modes[1:],
    ]
    model = msgspec.structs.replace(model, arm=msgspec.structs.replace(model.arm, modes=modes))
    windows = moving_spans(measured, 2.5 / first.frequency_hz)
    moved = bool(windows)
    return Start(_with_scales(measured, model, windows) if moved else model, first.power, moved)


def _with_frame_rate(measured: Measured, model: Model) -> Model:
    """The rate at which exposures were counted, where it is plainly not the one declared."""
    frames = measured.frames
    if len(frames) < 100 or model.camera.mode != "freerun":
        return model
    counts, arrived = frames.counter - frames.counter[0], frames.received_s
    if np.any(np.diff(counts) < 1):
        return model
    rate = 1.0 / float(np.polyfit(counts, arrived, 1)[0])
    jitter = model.timing.capture_delay_std_s + 0.01
    if abs(rate / model.camera.frame_rate_hz - 1.0) < max(2e-3, 3.0 * jitter / measured.duration_s):
        return model
    exposure = min(model.camera.exposure_s, 1.0 / rate)
    camera = msgspec.structs.replace(model.camera, frame_rate_hz=rate, exposure_s=exposure)
    return msgspec.structs.replace(model, camera=camera)


def _with_drive(measured: Measured, model: Model) -> Model:
    """Bandwidth and dead time that bring the simulated joint nearest to the reported one."""
    known = np.isfinite(measured.position)
    if measured.imposed or known.sum() < 50 or not commanded(measured).any():
        return model
    world = World(measured, model)
    at = world.space.place
    begin = float(measured.position[known][0])

    def left(where: Array) -> Array:
        vector = world.space.vector()
        vector[at["drive.bandwidth_hz"]] = np.exp(where[0])
        vector[at["drive.dead_time_s"]] = where[1] ** 2
        vector[at["start.theta"]], vector[at["start.omega"]] = begin, 0.0
        reported: Array = (world.reported_position(vector) - measured.position)[known]
        return reported[::4]

    best = None
    for hz in (4.0, 15.0, 60.0):
        one = least_squares(left, [np.log(hz), 0.06], x_scale=[0.1, 0.01], max_nfev=40)
        if best is None or one.cost < best.cost:
            best = one
    assert best is not None
    drive = msgspec.structs.replace(
        model.drive,
        bandwidth_hz=float(np.clip(np.exp(best.x[0]), 0.2, 1000.0)),
        dead_time_s=float(np.clip(best.x[1] ** 2, 0.0, 0.5)),
    )
    return msgspec.structs.replace(model, drive=drive)


def _stretches(world: World, spans: list[Span]) -> list[Stretch]:
    """All channels over all spans, in units of their noise."""
    found = []
    for name in ("acceleration", "displacement", "deflection"):
        if name not in world.channels:
            continue
        values = world.channels[name]
        time = world.frame_clock.grid_s if name == "displacement" else world.cycle_times
        if name == "displacement" and world.frame_clock.counted:
            time = time + float(np.nanmedian(world.measured.frames.received_s - time))
        known = np.isfinite(values) & np.isfinite(time)
        time, values = time[known], values[known]
        noise = max(white_noise(values, 3), 1e-6 * (float(np.std(values)) or 1.0), 1e-12)
        for begin, end in spans:
            # images are of the past: the first ones of a span may still show the move
            late = 0.15 if name == "displacement" else 0.0
            inside = (time >= begin + late) & (time < end)
            if inside.sum() >= 24:
                found.append(Stretch(time[inside] - time[inside][0], values[inside] / noise))
    return found


def _with_scales(measured: Measured, model: Model, windows: list[Span]) -> Model:
    """Participation, signed scales and capture delay by linear regression in windows about the moves."""
    world = World(measured, model)
    at = world.space.place
    vector = world.space.vector()
    vector[at["modes.0.participation"]] = 1.0
    for i in range(1, len(model.arm.modes)):
        vector[at[f"modes.{i}.participation"]] = 0.0
    known = np.isfinite(measured.position)
    if known.any():
        vector[at["start.theta"]] = float(measured.position[known][0])
    vector[at["start.omega"]] = 0.0
    motion = world.move(vector)
    q = motion.q[:, 0]
    rigid, rigid_pull = world.length * motion.joint[:, 0], world.length * motion.joint[:, 2]
    pull = motion.tip_acceleration - rigid_pull
    mode = model.arm.modes[0]
    w = mode.angular_frequency
    free = (w * sqrt(1.0 - mode.damping_ratio**2), mode.damping_ratio * w)
    found: list[_Shared] = []
    accelerometer, camera, timing = model.accelerometer, model.camera, model.timing
    sensed = world.channels.get("acceleration")
    if sensed is not None:
        t = world.cycle_times - accelerometer.delay_s
        grid = world.cycle_times
        one = _regress(
            world.cycle_times,
            sensed,
            [np.interp(t, grid, rigid_pull), np.interp(t, grid, pull)],
            windows,
            free,
        )
        found.append(one)
        accelerometer = msgspec.structs.replace(accelerometer, scale=one.signed_scale)
    if "displacement" in world.channels:
        one, delay = _image(world, rigid, q, windows, free)
        found.append(one)
        camera = msgspec.structs.replace(camera, scale_px_per_m=-one.signed_scale)
        timing = msgspec.structs.replace(timing, capture_delay_s=delay)
    if not found:
        return model
    weights = np.array([1.0 / max(one.participation_std, 1e-9) ** 2 for one in found])
    participation = float(np.sum(weights * [one.participation for one in found]) / weights.sum())
    if not np.isfinite(participation) or abs(participation) < 1e-3:
        participation = mode.participation
    modes = [
        msgspec.structs.replace(mode, participation=float(np.clip(participation, -20.0, 20.0))),
        *model.arm.modes[1:],
    ]
    return msgspec.structs.replace(
        model,
        arm=msgspec.structs.replace(model.arm, modes=modes),
        accelerometer=accelerometer,
        camera=camera,
        timing=timing,
    )


@dataclass(frozen=True)
class _Shared:
    """What a channel holds of the rigid motion and of the vibration, with what the fit leaves."""

    rigid: float
    vibration: float
    covariance: Array
    cost: float

    @property
    def signed_scale(self) -> float:
        return self.rigid if abs(self.rigid) > 1e-6 else 1e-3

    @property
    def participation(self) -> float:
        return self.vibration / self.signed_scale

    @property
    def participation_std(self) -> float:
        slope = np.array([-self.participation, 1.0]) / self.signed_scale
        return sqrt(max(float(slope @ self.covariance @ slope), 0.0))


def _regress(
    time: Array, values: Array, shared: list[Array], windows: list[Span], free: tuple[float, float]
) -> _Shared:
    """Least squares of the shared terms, a free vibration and a constant of its own taken out of each window."""
    wd, decay = free
    rows, targets = [], []
    for begin, end in windows:
        inside = (time >= begin) & (time < end) & np.isfinite(values)
        if inside.sum() < 12:
            continue
        t = time[inside] - begin
        fade = np.exp(-decay * t)
        own, _ = np.linalg.qr(
            np.column_stack((fade * np.cos(wd * t), fade * np.sin(wd * t), np.ones(len(t))))
        )
        terms = np.column_stack([one[inside] for one in shared])
        rows.append(terms - own @ (own.T @ terms))
        targets.append(values[inside] - own @ (own.T @ values[inside]))
    matrix, target = np.concatenate(rows), np.concatenate(targets)
    solved, *_ = np.linalg.lstsq(matrix, target, rcond=None)
    left = target - matrix @ solved
    cost = float(left @ left) / max(len(target) - 2, 1)
    covariance = np.asarray(np.linalg.pinv(matrix.T @ matrix) * cost, dtype=np.float64)
    return _Shared(float(solved[0]), float(solved[1]), covariance, cost)


def _image(
    world: World, rigid: Array, q: Array, windows: list[Span], free: tuple[float, float]
) -> tuple[_Shared, float]:
    """The image's two parts, and the capture delay at which they leave least."""
    clock, frames = world.frame_clock, world.measured.frames
    arrived = clock.grid_s + float(np.nanmean(frames.received_s - clock.grid_s))
    values, grid = world.measured.frames.displacement_px, world.cycle_times
    best: tuple[_Shared, float] | None = None
    late = [(begin, end + 0.1) for begin, end in windows]
    for delay in _DELAYS_S:
        at = arrived - delay
        one = _regress(at, values, [np.interp(at, grid, rigid), np.interp(at, grid, q)], late, free)
        if best is None or one.cost < best[0].cost:
            best = one, float(delay)
    assert best is not None
    return best
