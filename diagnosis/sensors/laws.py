"""Causes that change no mean: how values scatter, which frames come, when they come, and clocks that step.

Each compares two laws of the same values by their log-likelihood. Such events are rare, so each block of the recording
is judged by a law that was learnt on all the others (cross-validation), not the held-out blocks alone.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.frame_times import held_back, missing_requests
from stillarm.diagnosis.data.noise import HUBER, LEAST
from stillarm.diagnosis.data.robust import std_about_median
from stillarm.diagnosis.fitting.departures import stretches
from stillarm.diagnosis.fitting.fitted import Data, Fit
from stillarm.diagnosis.physics.copies import shared_out
from stillarm.diagnosis.sensors.accelerometer_faults import SURE_NATS, outliers, pulses, strikes, tops_of
from stillarm.diagnosis.sensors.late_bursts import find_bursts

Array = NDArray[np.float64]

OF_STAMPS = "captured_s alone steps: the camera's own clock"
_LONE_SPIKE = 15.0  # robust deviations; an impact that strikes so hard is heard to ring
_USUAL_LOSS = 1e-3  # of the frames: what a sound link is taken to lose
_LEAST_NATS = 8.0  # bursts over a wander alone: 3000 to 1

# within so many deviations of the delay that the model states late frames are normal, but for so many in a row
_BURST, _LASTING = 2.0, 5.0
_FOLDS = 3  # ways of holding out a part of the blocks
_BURSTS = "delay_bursts"
_AS_LATE = 0.1  # of the arrivals' scatter: by which no burst is told from none
_RARELY = 0.5  # of the frames: what most do is the usual


@dataclass(frozen=True, eq=False)
class LawFound:
    """A law that differs from the usual one. held_out_score: nats that it gains in each block, by the law of the
    others, (blocks,)."""

    cause: str
    values: dict[str, tuple[float, float]]
    held_out_score: Array
    note: str = ""


def laws(data: Data, last: Fit, earlier: tuple[Fit, list[LawFound]] | None = None) -> list[LawFound]:
    """All laws of noise and timing that this recording can show. earlier: a fit and the laws that were found on it; of
    bursts, which take seconds to find, where images come as late by both."""
    if earlier is not None and _as_late(last, earlier[0]):
        bursts = next((one for one in earlier[1] if one.cause == _BURSTS), None)
    else:
        bursts = _delay_bursts(data, last)
    found = [_impulse_noise(data, last), _frame_drops(data, last), bursts, _stamp_step(data, last)]
    return [one for one in found if one is not None]


def _as_late(last: Fit, earlier: Fit) -> bool:
    """Whether images come as late by both fits, each but for its mean: to less than what the simulation itself may be
    off, or a tenth of the scatter."""
    now, then = last.channel("arrival"), earlier.channel("arrival")
    if now is None or then is None:
        return now is then
    apart = now.off - then.off
    apart = apart[np.isfinite(apart)]
    return bool(np.ptp(apart) < max(LEAST["arrival"], _AS_LATE * then.sigma)) if len(apart) else False


def _sums(block: NDArray[np.int64], values: Array, count: int) -> Array:
    """Sum of the values of each block."""
    return np.bincount(block, values, count).astype(np.float64)


def _impulse_noise(data: Data, last: Fit) -> LawFound | None:
    """Samples that are far off, singly: each as likely as the share of such samples in the other blocks, which for the
    only one of a recording is half a sample (Jeffreys' prior).

    Their size counts as uniform in its logarithm over two decades; the usual noise has Huber's tails, so that one value
    is worth no more than its size.
    """
    found = outliers(data, last)
    if found is None:
        return None
    residual, known, sigma = found.residual, found.known, found.sigma
    spikes = tops_of(found)  # a filter spreads one over two samples
    u = np.abs(found.u)
    count = int(spikes.sum())
    plain = bool(u[spikes].max(initial=0.0) >= _LONE_SPIKE)
    if count == 0 or (count == 1 and not plain):
        return None
    lasting = pulses(data, found)
    if lasting is not None and lasting.sum() > SURE_NATS:
        return None
    if strikes(found.flags, last.predicted.motion.joint[:, 1], data.world.measured.cycle_s):
        return None
    block = data.blocks_of("acceleration")
    per_block = _sums(block, spikes.astype(float), len(data.split.held))
    samples = _sums(block, known.astype(float), len(data.split.held))
    share = (count - per_block + 0.5) / (known.sum() - samples + 1.0)
    far = np.log(share[block[spikes]] / (2.0 * np.maximum(u[spikes], 1.0) * np.log(100.0)))
    usual = np.minimum(0.5 * u[spikes] ** 2, HUBER * u[spikes] - 0.5 * HUBER**2) + 0.5 * np.log(2.0 * np.pi)
    gains = _sums(block[spikes], far + usual, len(data.split.held)) - samples * share
    size = float(np.mean(np.abs(residual[spikes])))
    spread = float(np.std(np.abs(residual[spikes]))) if count > 2 else 0.0
    rate = count / (float(known.sum()) * data.world.measured.cycle_s)
    return LawFound(
        "impulse_noise",
        {
            "rate_hz": (rate, rate / count**0.5),
            "amplitude_m_s2": (size, float(np.hypot(spread, sigma)) / count**0.5),
        },
        gains,
    )


def _frame_drops(data: Data, last: Fit) -> LawFound | None:
    """Frames that were exposed, or asked for, and never came, against a camera that loses one in a thousand."""
    clock, frames = data.world.frame_clock, data.world.measured.frames
    if len(frames) < 20:
        return None
    between = np.diff(clock.counts) - 1 if clock.counted else missing_requests(frames)
    if between is None:
        return None
    missing = np.concatenate(([0], between)).astype(float)
    missing[missing > 30] = 1.0
    lost = float(missing.sum())
    if lost < 3:
        return None
    block = data.split.blocks_of(frames.received_s)
    size = len(data.split.held)
    lost_of, seen_of = _sums(block, missing, size), _sums(block, np.ones(len(frames)), size)
    seen = float(len(frames))
    share = (lost - lost_of + 0.5) / (lost - lost_of + seen - seen_of + 1.0)
    gains = lost_of * np.log(share / _USUAL_LOSS) + seen_of * np.log((1.0 - share) / (1.0 - _USUAL_LOSS))
    fraction = lost / (lost + seen)
    return LawFound(
        "frame_drops",
        {"fraction": (fraction, float(np.sqrt(fraction * (1.0 - fraction) / (lost + seen))))},
        gains,
    )


def _delay_bursts(data: Data, last: Fit) -> LawFound | None:
    """Stretches in which frames come late (late_bursts.py), three ways of holding out a third."""
    arrivals = last.channel("arrival")
    if arrivals is None:
        return None
    residual = arrivals.off
    block = data.blocks_of("arrival")
    size = len(data.split.held)
    whole = find_bursts(residual, np.isfinite(residual))
    if whole is None:
        return None
    late = whole.late > 0.5
    runs = stretches(late)
    total = float((whole.nats - whole.plain_nats).sum())
    if len(runs) < 2 or total < _LEAST_NATS or whole.size_s < 2.0 * LEAST["arrival"]:
        return None
    if float(np.mean(late[np.isfinite(residual)])) > _RARELY:
        return None
    stated_s = data.world.model.timing.capture_delay_std_s
    frames = float(np.median([b - a for a, b in runs]))
    if whole.size_s < _BURST * stated_s and frames < _LASTING:
        return None
    gains = np.zeros(size)
    held_out = [block % _FOLDS == fold for fold in range(_FOLDS)]
    parts = shared_out(lambda out: find_bursts(residual, np.isfinite(residual) & ~out), held_out)
    for out, part in zip(held_out, parts, strict=True):
        if part is not None:
            gains += _sums(block[out], (part.nats - part.plain_nats)[out], size)
    period = 1.0 / data.world.model.camera.frame_rate_hz
    lengths = np.array([(end - a) * period for (a, _), end in zip(runs, _ends(residual, runs), strict=True)])
    duration = data.world.measured.duration_s
    depth = _depths(residual, runs)
    rate, usual = len(runs) / duration, float(np.median(lengths))  # one prolonged by another is longer
    return LawFound(
        _BURSTS,
        {
            "rate_hz": (rate, rate / float(np.sqrt(len(runs)))),
            "duration_s": (
                usual, 1.25 * float(lengths.std() / np.sqrt(len(runs))) + 0.3 * period,
            ),
            "delay_s": (float(np.mean(depth)), float(np.std(depth) / np.sqrt(len(runs))) + 1e-4),
        },
        gains,
    )  # fmt: skip


_HELD_UP = 0.75  # of a burst's median lateness: a frame below that only follows it


def _ends(residual: Array, runs: list[tuple[int, int]]) -> list[int]:
    """Where each burst ends: the frames after it are late only as they may not overtake its last ones."""
    usual = float(np.nanmedian(residual))
    ends = []
    for a, b in runs:
        late = residual[a:b] - usual
        full = np.flatnonzero(late > _HELD_UP * np.nanmedian(late))
        ends.append(a + int(full[-1]) + 1 if len(full) else b)
    return ends


def _depths(residual: Array, runs: list[tuple[int, int]]) -> Array:
    """How much later each burst's frames are than those about it, s."""
    inside = np.zeros(len(residual), bool)
    for a, b in runs:
        inside[a:b] = True
    depths = []
    for a, b in runs:
        near = np.arange(max(0, a - 30), min(len(residual), b + 30))
        near = near[~inside[near]]
        if len(near) > 2:
            depths.append(float(np.median(residual[a:b]) - np.median(residual[near])))
    return np.array(depths or [float(np.median(residual[inside]) - np.median(residual[~inside]))])


def _stamp_step(data: Data, last: Fit) -> LawFound | None:
    """The camera's own clock was set: stamps against the frames' grid jump once."""
    frames, clock = data.world.measured.frames, data.world.frame_clock
    stamps = frames.captured_s
    known = np.isfinite(stamps)
    if known.sum() < 40 or not clock.counted:
        return None
    if held_back(frames, 1.0 / data.world.model.camera.frame_rate_hz) is not None:
        return None  # an old image with its own stamp
    off = stamps[known] - clock.grid_s[known]
    x = clock.grid_s[known]
    # the largest single jump, straight lines of one slope on both sides
    jumps = np.diff(off)
    usual = float(np.median(jumps / np.maximum(np.diff(x), 1e-9)))
    jumps = jumps - usual * np.diff(x)
    i = int(np.argmax(np.abs(jumps)))
    noise = max(std_about_median(jumps), 2e-6)
    if abs(jumps[i]) < 12.0 * noise or abs(jumps[i]) < 1e-4:
        return None
    after = np.arange(len(off)) > i
    design = np.stack((np.ones_like(x), x, after.astype(float)), axis=1)
    solution, *_ = np.linalg.lstsq(design, off, rcond=None)
    rest = off - design @ solution
    plain = off - design[:, :2] @ np.linalg.lstsq(design[:, :2], off, rcond=None)[0]
    level, before = max(float(np.std(rest)), 1e-6), max(float(np.std(plain)), 1e-6)
    gain_all = np.zeros(len(stamps))
    gain_all[known] = (
        -0.5 * (rest / level) ** 2 - np.log(level) + 0.5 * (plain / before) ** 2 + np.log(before)
    )
    time = frames.received_s
    block = data.split.blocks_of(time)
    blocks = _sums(block, gain_all, len(data.split.held))
    onset = float(time[known][i + 1])
    return LawFound(
        "clock_step",
        {
            "onset_s": (onset, 1.0 / data.world.model.camera.frame_rate_hz),
            "step_s": (float(solution[2]), noise),
        },
        blocks,
        note=OF_STAMPS,
    )
