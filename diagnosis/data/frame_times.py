"""Steps and repeats in the times of frames: arrivals, requests and stamps, whatever the images show.

A step of the arrivals that is not in the model makes the wander of the delay seem quicker and larger than it is, and
such a wander then explains the step. So each law (stillarm.diagnosis.data.noise) is tried with a step before each
frame, by its likelihood, a level and a trend fitted beside it.

A buffer that begins to hand over old images with their own stamps shows an exposure twice, and all later ones late. A
triggered camera's frames are asked for: where the requests leave their interval, their clock was set, or where by whole
intervals, frames never came. A camera's clock that was set makes stamps step against requests and arrivals alike.
"""

from dataclasses import dataclass, replace
from math import log
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from stillarm.diagnosis.data.measured import Frames, Measured
from stillarm.diagnosis.data.noise import MIN_ARRIVALS, Colour, resolution, wander_colours
from stillarm.diagnosis.data.robust import SIDE, WHOLE, std_about_median, std_about_zero, step_at

Array = NDArray[np.float64]

# a step of the arrivals
_SURE_NATS = 5.0  # beyond what the best of so many places gains by chance

# a buffer that holds images back
MOST_HELD = 4
"""Frames that a queue is taken to hold at most, where nothing but the images tells."""

_SAME_S = 1e-4  # between stamps of one exposure
_MOST_FRAMES = 32  # before a frame, among which its exposure is looked for
_STAYS = 0.5  # of the frames held: so much later images stay

# requests
_REGULAR = 0.1  # of the interval: what requests that keep one may scatter by
_SELDOM = 0.1  # the share of intervals that may be off a whole number of them

# stamps
_KNOWN = 0.8  # of the frames
_BESIDE = 60  # frames: a clock may be set in parts, within a second


@dataclass(frozen=True)
class ArrivalStep:
    """The likeliest step of the arrivals. index: of the first frame after it; step_s: later by, s, with its standard
    deviation; nats: gained."""

    index: int
    step_s: float
    std_s: float
    nats: float


def arrival_step(residual: Array, longest_frames: float) -> ArrivalStep | None:
    """The step that the residual arrivals (s, NaN where unknown) show, if one does. longest_frames: of a wander."""
    known = np.flatnonzero(np.isfinite(residual))
    n = len(known)
    if n < MIN_ARRIVALS:
        return None
    r = residual[known] - float(np.median(residual[known]))
    none, best, place, size, doubt = -np.inf, -np.inf, 0, 0.0, 0.0
    for colour in wander_colours(longest_frames):
        plain, stepped, steps, stds = _likelihoods(r, colour)
        none = max(none, plain)
        at = int(np.argmax(stepped))
        if stepped[at] > best:
            best, place, size, doubt = float(stepped[at]), at, float(steps[at]), float(stds[at])
    gained = best - none
    return ArrivalStep(int(known[place]), size, doubt, gained) if gained > log(n) + _SURE_NATS else None


def _likelihoods(r: Array, colour: Colour) -> tuple[float, Array, Array, Array]:
    """Profile log-likelihood without a step, and with one before each frame; each one's size, and its standard
    deviation. A level and a trend are fitted beside it."""
    n = len(r)

    def white(values: Array) -> Array:
        out: Array = lfilter([1.0, -colour.stay], [1.0, -colour.moving], values)
        return out

    design, _ = np.linalg.qr(np.stack((white(np.ones(n)), white(np.linspace(-1.0, 1.0, n))), axis=1)[1:])
    values = white(r)[1:]
    values = values - design @ (design.T @ values)
    # a step before frame k is the filter's answer to a step, k frames late: all its products are one filter run back
    answer = white(np.ones(n))
    along = _back(values, answer)
    squares = np.cumsum(answer**2)[n - 2 :: -1]
    shares = np.stack([_back(column, answer) for column in design.T])
    norms = np.maximum(squares - np.sum(shares**2, axis=0), 1e-12 * n)
    left = float(values @ values)
    gains = along**2 / norms
    gains[:SIDE] = gains[-SIDE:] = 0.0
    stepped = -0.5 * n * np.log(np.maximum(left - gains, 1e-12 * left + 1e-300))
    plain = -0.5 * n * log(max(left, 1e-300))
    stds = np.sqrt(np.maximum(left - gains, 0.0) / n / norms)
    first = np.zeros(1)  # a step before the first frame is none
    return (
        plain, np.concatenate((first - np.inf, stepped)), np.concatenate((first, along / norms)),
        np.concatenate((first, stds)),
    )  # fmt: skip


def _back(values: Array, answer: Array) -> Array:
    """Inner products of values with `answer` begun at each of their places."""
    n = len(values)
    size = 1 << (2 * n - 1).bit_length()
    spectrum = np.fft.rfft(values, size) * np.conj(np.fft.rfft(answer[:n], size))
    return np.asarray(np.fft.irfft(spectrum, size)[:n], dtype=np.float64)


@dataclass(frozen=True)
class Held:
    """From the frame at place `first` on, images are `frames` exposures older than they were."""

    first: int
    frames: int


def held_back(frames: Frames, period_s: float) -> Held | None:
    """The first exposure that comes again as a later frame, if the stamps stay behind from there on."""
    stamps = frames.captured_s
    if frames.asked or np.isfinite(stamps).sum() < 2 * SIDE:
        return None
    late = frames.received_s - stamps
    for i in (np.flatnonzero(np.diff(stamps) < 0.5 * period_s) + 1).tolist():
        before = stamps[max(0, i - _MOST_FRAMES) : i][::-1]
        again = np.flatnonzero(np.abs(before - stamps[i]) < _SAME_S)
        if not len(again):
            continue
        many = int(again[0]) + 1
        if step_at(late, i, SIDE) > _STAYS * many * period_s:
            return Held(i, many)
    return None


def without(measured: Measured, held: Held, period_s: float) -> Measured:
    """The recording with the images as late as they were before."""
    late = np.where(np.arange(len(measured.frames)) >= held.first, held.frames * period_s, 0.0)
    frames = measured.frames
    return replace(measured, frames=replace(frames, received_s=frames.received_s - late))


@dataclass(frozen=True)
class Intervals:
    """By how much each request came off its interval after the last, (frames - 1,) s, and how much is usual, s."""

    off_s: Array
    usual_s: float


def request_intervals(measured: Measured) -> Intervals:
    """The intervals of a recording's requests. They are noted to the cycle, so that no less than one is usual."""
    between = np.diff(measured.frames.started_s)
    off = between - float(np.median(between))
    return Intervals(off, std_about_zero(off) + measured.cycle_s)


def missing_requests(frames: Frames) -> NDArray[np.int64] | None:
    """How many frames never came between each and the next, (frames - 1,): what the counter skips, or whole intervals
    that a triggered camera's stamps or requests leave out. None where neither keeps an interval."""
    skipped = np.diff(frames.counter) - 1
    if np.any(skipped > 0) and np.all(skipped >= 0):
        return skipped
    for times in (frames.captured_s, frames.started_s):
        between = np.diff(times)
        if len(between) == 0 or not np.isfinite(between).all():
            continue
        between = between / float(np.median(between))
        whole = np.rint(between).astype(np.int64)
        off = np.abs(between - whole) > WHOLE
        if std_about_median(between) < _REGULAR and float(np.mean(off)) < _SELDOM:
            return np.maximum(whole - 1, 0)
    return None


class SetStamps(NamedTuple):
    """The first frame whose stamp is of the clock that was set, and by how much, s, with its standard deviation."""

    first: int
    step_s: float
    std_s: float


def stamps_apart(frames: Frames) -> Array | None:
    """A camera's stamps less the requests, or less the arrivals where those scatter less, s, (frames,), NaN where
    unknown; None without stamps."""
    apart = [frames.captured_s - other for other in (frames.started_s, frames.received_s)]
    known = [one for one in apart if np.isfinite(one).mean() > _KNOWN]
    if frames.asked or not known:
        return None
    return min(known, key=lambda one: std_about_median(np.diff(one[np.isfinite(one)])))


def set_stamps(frames: Frames, longest_frames: float) -> SetStamps | None:
    """The step of a camera's stamps against the controller's clock; None where they go on alike. longest_frames: that
    the time between them wanders over."""
    apart = stamps_apart(frames)
    step = None if apart is None else arrival_step(apart, longest_frames)
    if apart is None or step is None:
        return None
    size_s = step_at(apart, step.index, _BESIDE)
    return None if _is_of_rounding(apart, size_s) else SetStamps(step.index, size_s, step.std_s)


def _is_of_rounding(apart: Array, step_s: float) -> bool:
    """Whether the time between two stamps steps by what their rounding makes of a slow change: by one unit, as it does
    elsewhere."""
    known = apart[np.isfinite(apart)]
    unit = resolution(known)
    steps = np.abs(np.diff(known))
    often = int(np.sum((steps > 0.5 * unit) & (steps < 1.5 * unit))) > 1
    return often and abs(step_s) < 1.5 * unit


def taken_back(measured: Measured, step: SetStamps) -> Measured:
    """The same data, the stamps those of a clock that was never set."""
    stamps = measured.frames.captured_s.copy()
    stamps[step.first :] -= step.step_s
    return replace(measured, frames=replace(measured.frames, captured_s=stamps))
