"""Which exposure each frame was: the grid on which a camera's frames lie, apart from when they arrived.

Freerun: frame k was exposed at t0 + n_k T, whatever happened to it afterwards. n_k is the counter's where that counts
exposures; a counter of arrivals does not tell of lost frames, but they leave the arrivals late by whole frames for
good. Triggered with stamps: the stamps are the grid. Triggered without: the arrivals themselves, less the delay.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.model import Model
from stillarm.diagnosis.data.lost_frames import lost_before, scatter
from stillarm.diagnosis.data.measured import Frames
from stillarm.diagnosis.data.robust import OUTLYING, SIDE, std_about_zero, step_at

Array = NDArray[np.float64]

_LARGEST_STEP = 200  # frames: a counter that jumps further was reset
# frames that tell a rate; by how much a clock jumps at least, s; jumps, of more of which no rate is left to be told
_FEWEST, _LEAST_JUMP_S, _MOST_JUMPS = 100, 1e-3, 5
# s/s: ten times the 20 ppm that crystals are sold to, more is no clock's rate; standard errors: chance 1 in 370
_QUARTZ, _SURE = 2e-4, 3.0
_WHOLE, _SET = 0.15, 0.5  # of a frame; of the frames lost


@dataclass(frozen=True)
class FrameClock:
    """grid_s: instant of each frame on its own clock, s, zero at the middle frame; NaN for one without.

    counted: freerun, instants follow from counts; arrival: instants are only known as arrival minus delay.
    lost: frames that were exposed and never came; exposed: how many were.
    arrival_s: received_s - grid_s, about its mean where counted (what the delay's law is seen in).
    """

    grid_s: Array
    counts: NDArray[np.int64]
    counted: bool
    arrival: bool
    lost: int
    exposed: int


def frame_clock(frames: Frames, model: Model) -> FrameClock:
    """Work out the grid of the frames."""
    camera = model.camera
    period = 1.0 / camera.frame_rate_hz
    counts = exposure_counts(frames, period)
    lost = int(np.sum(np.diff(counts) - 1)) if len(counts) > 1 else 0
    exposed = int(counts[-1] - counts[0] + 1) if len(counts) else 0
    if camera.mode == "freerun":
        middle = counts[len(counts) // 2] if len(counts) else 0
        return FrameClock((counts - middle) * period, counts, True, False, max(lost, 0), exposed)
    stamped = np.isfinite(frames.captured_s)
    if len(frames) and stamped.mean() > 0.8:
        stamps = frames.captured_s - float(np.nanmedian(frames.captured_s))
        stamps = stamps * _tick_of_stamps(frames)
        grid = stamps + float(np.nanmedian(frames.received_s - stamps))
        return FrameClock(grid, counts, False, False, 0, exposed)
    return FrameClock(frames.received_s.copy(), counts, False, True, 0, exposed)


def _tick_of_stamps(frames: Frames) -> float:
    """Seconds of the controller to one of the camera's clock: no two quartzes agree, and half a millisecond shows in a
    quick image. By the requests, but for jumps of either clock, and no more than quartzes differ by."""
    known = np.isfinite(frames.captured_s) & np.isfinite(frames.started_s)
    if frames.asked or known.sum() < _FEWEST:
        return 1.0
    stamps = frames.captured_s[known]
    apart = frames.started_s[known] - stamps
    steps = np.diff(apart)
    off = np.abs(steps - np.median(steps))
    jumps = np.flatnonzero(off > OUTLYING * std_about_zero(off) + _LEAST_JUMP_S)
    if len(jumps) > _MOST_JUMPS:
        return 1.0
    x = stamps - stamps.mean()
    design = np.stack([x, np.ones(len(x)), *(np.arange(len(x)) > i for i in jumps)], axis=1)
    amounts, *_ = np.linalg.lstsq(design, apart - apart[0], rcond=None)
    left = apart - apart[0] - design @ amounts
    spread = float(np.linalg.pinv(design.T @ design)[0, 0] * np.mean(left**2)) ** 0.5
    told = _SURE * spread < abs(float(amounts[0])) < _QUARTZ
    return 1.0 + float(amounts[0]) if told else 1.0


def exposure_counts(frames: Frames, period_s: float) -> NDArray[np.int64]:
    """Number of the exposure of each frame: the counter, mended where arrivals prove it a counter of arrivals."""
    counter, received = frames.counter, frames.received_s
    n = len(counter)
    if n < 2:
        return counter.copy()
    step = np.diff(counter)
    passed = np.diff(received) / period_s
    bad = (step < 1) | (step > _LARGEST_STEP) | (step > 4 * passed + 20)
    step = np.where(bad, np.maximum(1, np.rint(passed)).astype(np.int64), step)
    if not frames.counted and not np.any(step[~bad] > 1):  # nowhere does it skip: it may count arrivals
        lost = _lost_by_stamps(frames, step, period_s)
        if lost is None:
            lost = lost_before(_steadier(frames, step, period_s), step, period_s)[1:]
        step = step + lost
    counts: NDArray[np.int64] = np.concatenate(([0], np.cumsum(step))) + counter[0]
    return counts


def _lost_by_stamps(frames: Frames, step: NDArray[np.int64], period_s: float) -> NDArray[np.int64] | None:
    """Frames lost in each interval, where a running camera's own stamps lie whole periods apart and the arrivals bear
    out each loss: nothing else tells of one just before the recording's end. None where they do not."""
    intervals = np.diff(frames.captured_s) / period_s
    if frames.asked or not np.isfinite(intervals).all():
        return None
    lost = np.rint(intervals).astype(np.int64) - step
    if np.any(lost < 0) or np.any(np.abs(intervals - step - lost) > _WHOLE):
        return None
    late = (frames.received_s - frames.captured_s) / period_s  # set at a loss: a clock was, and no frame lost
    set_by = [abs(step_at(late, i + 1, SIDE)) / lost[i] for i in np.flatnonzero(lost).tolist()]
    return lost if max(set_by, default=0.0) <= _SET else None


def _steadier(frames: Frames, step: NDArray[np.int64], period_s: float) -> Array:
    """When frames came, or where that scatters less, when they were begun: what was lost left a gap in either. The
    first is begun whenever the supervisor is, and says nothing of the second."""
    began = frames.started_s.copy()
    if not np.isfinite(began).all():
        return frames.received_s
    began[0] = began[1] - step[0] * period_s
    return min((frames.received_s, began), key=lambda times: scatter(times, step, period_s))
