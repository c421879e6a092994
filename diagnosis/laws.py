"""Causes that change no mean: how values scatter, which frames come, when they come, and clocks that step.

Each compares two laws of the same residual by their log-likelihood, the parameters learnt on the training part alone.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.fit import Data, Fit
from diagnosis.measured import ClockGap

Array = NDArray[np.float64]

_SPIKE = 6.0  # robust deviations
_BURST = 4.0


@dataclass(frozen=True)
class LawFound:
    """A law that differs from the usual one. train_nats, held_nats (per held-out block): gain of log-likelihood."""

    cause: str
    values: dict[str, tuple[float, float]]
    train_nats: float
    held_nats: Array
    note: str = ""


def laws(data: Data, last: Fit) -> list[LawFound]:
    """All laws of noise and timing that this recording can show."""
    found = [
        _impulse_noise(data, last),
        _frame_drops(data, last),
        _delay_bursts(data, last),
        _stamp_step(data, last),
    ]
    return [one for one in found if one is not None]


def _sums(block: NDArray[np.int64], values: Array, count: int) -> Array:
    """Sum of the values of each block."""
    return np.bincount(block, values, count).astype(np.float64)


def _robust(values: Array) -> float:
    return 1.4826 * float(np.median(np.abs(values - np.median(values)))) + 1e-12


def _per_block(data: Data, name: str, values: Array) -> tuple[float, Array]:
    """Sum over the training part, and over each held-out block."""
    train, held = data.train[name], data.held[name]
    blocks = _sums(data.blocks[name][held], values[held], len(data.split.held))
    return float(values[train].sum()), blocks


def _impulse_noise(data: Data, last: Fit) -> LawFound | None:
    """Spikes of one sample: a mixture of the usual noise and noise about +-A (expectation maximisation)."""
    if "acceleration" not in data.world.channels:
        return None
    residual = data.world.channels["acceleration"] - last.predicted.channels["acceleration"]
    train = residual[data.train["acceleration"]]
    sigma = _robust(train)
    spikes = np.abs(train) > _SPIKE * sigma
    if spikes.sum() < 3:
        return None
    core = float(np.std(train[~spikes]))
    share, size = float(spikes.mean()), float(np.mean(np.abs(train[spikes])))
    spread = max(float(np.std(np.abs(train[spikes]))), core)
    for _ in range(30):
        usual = (1.0 - share) * _normal(train, core)
        spike = share * 0.5 * (_normal(train - size, spread) + _normal(train + size, spread))
        odds = spike / np.maximum(usual + spike, 1e-300)
        share = float(odds.mean())
        if share <= 0.0:
            return None
        size = float((odds * np.abs(train)).sum() / odds.sum())
        spread = max(float(np.sqrt((odds * (np.abs(train) - size) ** 2).sum() / odds.sum())), core)
        core = float(np.sqrt(((1.0 - odds) * train**2).sum() / (1.0 - odds).sum()))
    mixed = (1.0 - share) * _normal(residual, core) + share * 0.5 * (
        _normal(residual - size, spread) + _normal(residual + size, spread)
    )
    plain = _normal(residual, float(np.std(train)))
    gain = np.nan_to_num(np.log(np.maximum(mixed, 1e-300)) - np.log(np.maximum(plain, 1e-300)))
    if size < 4.0 * core:
        return None
    nats, held = _per_block(data, "acceleration", gain)
    cycle = data.world.measured.cycle_s
    count = max(share * len(train), 1.0)
    return LawFound(
        "impulse_noise",
        {
            "rate_hz": (share / cycle, share / cycle / np.sqrt(count)),
            "amplitude_m_s2": (size, float(np.hypot(spread, core)) / float(np.sqrt(count))),
        },
        nats,
        held,
    )


def _normal(x: Array, std: float) -> Array:
    result: Array = np.exp(-0.5 * np.clip(x / std, -37.0, 37.0) ** 2) / (std * np.sqrt(2.0 * np.pi))
    return result


def _frame_drops(data: Data, last: Fit) -> LawFound | None:
    """Frames that were exposed and never came, against a camera that loses one in ten thousand."""
    clock, frames = data.world.frame_clock, data.world.measured.frames
    if not clock.counted or len(frames) < 20:
        return None
    missing = np.concatenate(([0], np.diff(clock.counts) - 1)).astype(float)
    missing[missing > 30] = 1.0
    time = frames.received_s
    block = data.split.blocks_of(time)
    held = data.split.held[block]
    usual = 1e-4
    lost, seen = float(missing[~held].sum()), float((~held).sum())
    share = lost / max(lost + seen, 1.0)
    if share <= 2.0 * usual or lost < 3:
        return None
    gain = missing * np.log(share / usual) + np.log((1.0 - share) / (1.0 - usual))
    blocks = _sums(block[held], gain[held], len(data.split.held))
    total = float(missing.sum() / (missing.sum() + len(frames)))
    return LawFound(
        "frame_drops",
        {"fraction": (total, float(np.sqrt(total * (1.0 - total) / (len(frames) + missing.sum()))))},
        float(gain[~held].sum()),
        blocks,
    )


def _delay_bursts(data: Data, last: Fit) -> LawFound | None:
    """Stretches in which frames come late, in a hidden Markov chain of two states."""
    if "arrival" not in data.world.channels:
        return None
    residual = data.world.channels["arrival"] - last.predicted.channels["arrival"]
    base = residual - _running_median(residual, 101)
    train = data.train["arrival"]
    sigma = max(_robust(base[train]), 0.0003)
    late = base > _BURST * sigma
    runs = _runs(late & (_grown(late)))
    runs = [(a, b) for a, b in runs if b - a >= 2]
    if len(runs) < 2:
        return None
    inside = np.zeros(len(base), bool)
    for a, b in runs:
        inside[a:b] = True
    lateness = np.array([np.max(base[a:b]) for a, b in runs])
    period = 1.0 / data.world.model.camera.frame_rate_hz
    lengths = np.array([(b - a) * period for a, b in runs])
    duration = data.world.measured.duration_s
    size, spread = float(np.median(base[inside])), max(float(np.std(base[inside])), sigma)
    enter, leave = len(runs) / max(len(base), 1), len(runs) / max(float(inside.sum()), 1.0)
    free, burst = np.log(_normal(base, sigma) + 1e-300), np.log(_normal(base - size, spread) + 1e-300)
    mixed = _chain(free, burst, enter, min(leave, 0.9))
    whole = float(np.std(base[train]))
    plain = np.log(_normal(base, whole) + 1e-300)
    nats, held = _per_block(data, "arrival", mixed - plain)
    count = len(runs)
    return LawFound(
        "delay_bursts",
        {
            "rate_hz": (count / duration, float(np.sqrt(count)) / duration),
            "duration_s": (float(lengths.mean()), float(lengths.std() / np.sqrt(count)) + 0.5 * period),
            "delay_s": (float(np.median(lateness)), float(lateness.std() / np.sqrt(count))),
        },
        nats,
        held,
    )


def _grown(flags: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Flags with a neighbour that is one too."""
    near = np.zeros_like(flags)
    near[1:] |= flags[:-1]
    near[:-1] |= flags[1:]
    return near


def _runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate(([0], flags.astype(int), [0]))))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _running_median(values: Array, width: int) -> Array:
    from scipy.ndimage import median_filter

    result: Array = median_filter(values, size=min(width, max(3, len(values) // 2 * 2 - 1)), mode="nearest")
    return result


def _chain(free: Array, burst: Array, enter: float, leave: float) -> Array:
    """Predictive log-likelihood of each value under a chain of two states, given those before it."""
    out = np.empty(len(free))
    p = enter / (enter + leave)
    for k, (a, b) in enumerate(zip(free.tolist(), burst.tolist(), strict=True)):
        p = p * (1.0 - leave) + (1.0 - p) * enter
        top = max(a, b)
        ea, eb = (1.0 - p) * np.exp(a - top), p * np.exp(b - top)
        out[k] = top + np.log(ea + eb)
        p = eb / (ea + eb)
    return out


def _stamp_step(data: Data, last: Fit) -> LawFound | None:
    """The camera's own clock was set: stamps against the frames' grid jump once."""
    frames, clock = data.world.measured.frames, data.world.frame_clock
    stamps = frames.captured_s
    known = np.isfinite(stamps)
    if known.sum() < 40 or not clock.counted:
        return None
    off = stamps[known] - clock.grid_s[known]
    x = clock.grid_s[known]
    # the largest single jump, straight lines of one slope on both sides
    jumps = np.diff(off)
    usual = float(np.median(jumps / np.maximum(np.diff(x), 1e-9)))
    jumps = jumps - usual * np.diff(x)
    i = int(np.argmax(np.abs(jumps)))
    noise = max(_robust(jumps), 2e-6)
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
    held = data.split.held[block]
    blocks = _sums(block[held], gain_all[held], len(data.split.held))
    onset = float(time[known][i + 1])
    return LawFound(
        "clock_step",
        {
            "onset_s": (onset, 1.0 / data.world.model.camera.frame_rate_hz),
            "step_s": (float(solution[2]), noise),
        },
        float(gain_all[~held].sum()),
        blocks,
        note="captured_s alone steps: the camera's own clock",
    )


def backward_steps(data: Data) -> list[LawFound]:
    """time_s stepped back: no cause but the clock can do that."""
    found = []
    measured = data.world.measured
    for gap in measured.backward:
        found.append(_of_gap(data, gap))
    return found


def _of_gap(data: Data, gap: ClockGap) -> LawFound:
    measured = data.world.measured
    blocks = np.where(data.split.held, 1000.0 / max(int(data.split.held.sum()), 1), 0.0)
    return LawFound(
        "clock_step",
        {
            "onset_s": (gap.cycle * measured.cycle_s, measured.cycle_s),
            "step_s": (gap.extra_s, measured.cycle_s),
        },
        1000.0,
        blocks,
        note="time_s itself steps, in both files",
    )


Law = Callable[[Data, Fit], LawFound | None]
