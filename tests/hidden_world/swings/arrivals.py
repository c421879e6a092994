"""When images are exposed, and when the controller reads them: in order, by one server that stalls now and then."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tests.hidden_world.swings.rig import TICK_S, Case

Values = NDArray[np.float64]
_TRIGGER_S = 0.0003
_STAMP_JITTER_S = 1e-6


@dataclass(frozen=True)
class Images:
    """Of the images that are read, shape (images,): number, middle_s, received_s, started_s, stamp_s (NaN: none)."""

    number: NDArray[np.int64]
    middle_s: Values
    received_s: Values
    started_s: Values
    stamp_s: Values


def images(case: Case) -> Images:
    """All images of a case that are read before it ends."""
    camera, law = case.camera, case.arrivals
    luck = np.random.default_rng((case.seed, 31))
    count = int((case.duration_s - 0.5) * camera.frame_rate_hz)
    index = np.arange(count)
    period_s = 1.0 / camera.frame_rate_hz
    asked = luck.uniform(0.0, period_s) + index * period_s
    if camera.triggered:
        asked = asked + luck.uniform(0.0, TICK_S, count)
        start = asked + _TRIGGER_S
    else:
        asked = start = asked[0] + index * period_s * (1.0 + camera.rate_error)
    middle = start + 0.5 * camera.exposure_s
    lost = luck.random(count) < law.lost_share
    ready = middle + lateness(case, middle, luck)
    stalls = _stalls(case, luck)
    received = serve(ready, law.service_s, stalls, lost)
    if law.queue:
        lost |= (received - ready) > law.queue * period_s
        received = serve(ready, law.service_s, stalls, lost)
    received = _ticks(received)
    stamp = np.full(count, np.nan)
    if camera.stamped:
        stamp = (middle + luck.uniform(-5.0, 5.0)) + luck.normal(0.0, _STAMP_JITTER_S, count)
    started = _started(case, asked, received, luck)
    keep = ~lost & (received < case.duration_s - TICK_S)
    return Images(index[keep], middle[keep], received[keep], started[keep], stamp[keep])


def lateness(case: Case, middle: Values, luck: np.random.Generator) -> Values:
    """Of each image were it alone, s: never less than the floor."""
    law, count = case.arrivals, len(middle)
    rest = luck.gamma(law.rest_shape, law.rest_mean_s / law.rest_shape, count)
    tail = np.where(luck.random(count) < law.tail_share, law.tail_s * luck.pareto(2.0, count), 0.0)
    return np.asarray(law.floor_s + np.abs(_walk(case, count, luck)) + rest + np.minimum(tail, 0.3))


def _walk(case: Case, count: int, luck: np.random.Generator) -> Values:
    """An Ornstein-Uhlenbeck process, smoothed over a fifth of its time constant."""
    law = case.arrivals
    step_s = 1.0 / case.camera.frame_rate_hz
    keep = np.exp(-step_s / law.walk_time_s)
    value, out = luck.normal(), np.zeros(count)
    noise = luck.normal(0.0, np.sqrt(1.0 - keep * keep), count)
    for k in range(count):
        value = keep * value + noise[k]
        out[k] = value
    width = max(1, int(0.2 * law.walk_time_s / step_s))
    padded = np.pad(out, width, mode="edge")
    smooth = np.convolve(padded, np.full(2 * width + 1, 1.0 / (2 * width + 1)), mode="valid")
    return law.walk_s * smooth


def _stalls(case: Case, luck: np.random.Generator) -> list[tuple[float, float]]:
    """Spans in which nothing is read."""
    law = case.arrivals
    out = [(0.0, law.start_stall_s)] if law.start_stall_s > 0.0 else []
    t = law.start_stall_s
    while law.stall_rate_hz > 0.0:
        t += luck.exponential(1.0 / law.stall_rate_hz)
        if t > case.duration_s:
            break
        out.append((t, t + law.stall_s * luck.gamma(3.0, 1.0 / 3.0)))
    return out


def serve(
    ready: Values, service_s: float, stalls: list[tuple[float, float]], lost: NDArray[np.bool_]
) -> Values:
    """When each is read: not before it is ready, nor while the server stalls, nor before the one before is done."""
    out, free, stall = np.array(ready), -1.0, 0
    for k in range(len(ready)):
        if lost[k]:
            continue
        at = max(ready[k], free)
        while stall < len(stalls) and stalls[stall][1] <= at:
            stall += 1
        if stall < len(stalls) and stalls[stall][0] <= at:
            at = stalls[stall][1]
        out[k], free = at, at + service_s
    return out


def _ticks(received: Values) -> Values:
    """The cycle that reads it: the first one after it has come, whole milliseconds."""
    return np.asarray(np.ceil(received / TICK_S - 1e-9) * TICK_S)


def _started(case: Case, asked: Values, received: Values, luck: np.random.Generator) -> Values:
    """n_i: the cycle of the request; of a free camera soon after its exposure, or when the image before was handled."""
    count = len(asked)
    if case.camera.triggered:
        return np.asarray(np.floor(asked / TICK_S) * TICK_S)
    after_exposure = asked + case.camera.exposure_s + luck.gamma(1.0, 0.003, count)
    if case.seed % 2:
        return np.asarray(np.ceil(after_exposure / TICK_S) * TICK_S)
    before = np.concatenate(([0.0], received[:-1]))
    return np.asarray(np.maximum(0.0, before))
