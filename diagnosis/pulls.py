"""A slow pull at the arm, and its release: something unknown holds the arm for a while, and lets it go.

What the arm shows meanwhile is the pull's, which no model foretells, so it is not judged; from the release on the arm
rings from a state of its own. A pull is seen in the images: it bends the arm to one side for longer than a part of a
swing, and ends where the vibration jumps.
"""

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.fit import Fit
from stillarm.diagnosis.robust import white_noise

Array = NDArray[np.float64]

_WINDOW_S = 0.2  # over which an image's departure is looked at
_LOUD = 6.0  # times the usual departure, in which one window in a thousand lies by chance
_GAP_S, _LEAD_S = 0.15, 0.3  # within a pull; before it shows
_SHORTEST_S, _LONGEST_S = 0.25, 8.0
_ONE_SIDED = 0.5  # of the departure's power is its mean's: a swing has none
_MOST = 0.3  # of the recording


def pull_spans_s(fit: Fit) -> tuple[tuple[float, float], ...]:
    """Spans in which something held the arm, from and to, s; each ends where the vibration jumps, or at none."""
    images = fit.channel("displacement")
    if images is None or len(images.off) < 100:
        return ()
    known = np.isfinite(images.off)
    time, off = fit.world.instants(fit.vector)[known], images.off[known]
    rate = 1.0 / fit.world.step_s("displacement")
    width = max(3, round(_WINDOW_S * rate))
    loudness = np.sqrt(np.convolve(off**2, np.full(width, 1.0 / width), "same"))
    usual = max(float(np.median(loudness)), white_noise(off))
    loud = loudness > _LOUD * usual
    spans = []
    cycle_s = fit.world.measured.cycle_s
    for cycle in fit.world.impacts:
        end = cycle * cycle_s
        start = _start(time, loud, end)
        if start is None or not _SHORTEST_S < end - start < _LONGEST_S:
            continue
        inside = off[(time >= start) & (time < end)]
        if len(inside) < 4 or np.mean(inside) ** 2 < _ONE_SIDED * np.mean(inside**2):
            continue
        spans.append((max(start - _LEAD_S, 0.0), end))
    if sum(end - start for start, end in spans) > _MOST * fit.world.measured.duration_s:
        return ()
    return tuple(_merged(spans))


def _start(time: Array, loud: NDArray[np.bool_], end: float) -> float | None:
    """Where the loud stretch that lasts until `end` began; None where there is none."""
    before = np.flatnonzero((time < end - 0.5 * _WINDOW_S) & (time > end - _LONGEST_S - 1.0))
    start, quiet_since = None, None
    for i in before[::-1]:
        if loud[i]:
            start, quiet_since = float(time[i]), None
            continue
        quiet_since = float(time[i]) if quiet_since is None else quiet_since
        if quiet_since - time[i] > _GAP_S:
            break
    return start


def _merged(spans: list[tuple[float, float]]) -> list[tuple[float, float]]:
    found: list[tuple[float, float]] = []
    for start, end in sorted(spans):
        if found and start <= found[-1][1]:
            found[-1] = (found[-1][0], max(end, found[-1][1]))
        else:
            found.append((start, end))
    return found
