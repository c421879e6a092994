"""What a residual does beside its mean: remembers, is driven at the mode's frequency, or scatters unevenly.

Each law is held against white noise of one level by the log-likelihood of the held-out part; that of rare things by
the log-likelihood of every block, learnt on the others.
"""

from dataclasses import dataclass
from math import pi

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.signal import lfilter

from stillarm.diagnosis.channels import FRAME_CHANNELS
from stillarm.diagnosis.fit import Data, Fit
from stillarm.diagnosis.outliers import outliers, pulses, within_range
from stillarm.diagnosis.steady_spectrum import steady_spectrum
from stillarm.diagnosis.unpredictable import unpredictable

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

ON_ITS_PAST = "each value depends on those before it"
"""The dependence of what is left of a motion that the simulation does not have."""
ITS_SPECTRUM_STAYS = "parts of its spectrum are stronger for a while"
"""The dependence of what sounds in a band of its own: another axis, gears, bursts of coloured noise."""
LASTING = "what stands out lasts for several samples"
"""The dependence of blows and jerks on what is measured, short as spikes, which are single samples."""

_LAGS = 12
_CLIP = 6.0
_SPIKE = 5.0
# Of the level: what is left lies below what a simulation is taken to reach (stillarm.diagnosis.noise.LEAST)
_AT_THE_FLOOR = 0.5
ENCODER = ("joint_position", "joint_velocity")  # whose steps scatter less while the joint stands
_ROUNDED = (
    0.5  # of an encoder's step: below it what is left is its rounding, which stays while the joint stands
)
_NO_STEP = 1e-9  # rad: told apart by rounding of the file alone
_BINS = 5


@dataclass(frozen=True)
class Uneven:
    """A law that fits better than white noise. train_nats: gained on the training part; block_nats: held out.

    everywhere: each block is judged by what was learnt on all the others, so that all count, not the held-out alone;
    train_nats are then the sum of them. most: the highest level that the law has, over the channel's own.
    """

    channel: str
    law: str
    train_log_likelihood: float
    block_nats: Array
    everywhere: bool = False
    most: float = np.inf


def uneven(data: Data, last: Fit, without_spikes: bool = False) -> list[Uneven]:
    """Every law for every channel. without_spikes: the accelerometer's are known, and left out."""
    found = []
    for name in last.residuals:
        residual = last.residuals[name] / last.sigma[name]
        known = np.isfinite(residual)
        if name == "acceleration":
            known &= within_range(last)
            if without_spikes:
                spikes = np.abs(np.nan_to_num(residual)) > _SPIKE
                known &= ~(spikes | np.roll(spikes, 1))
            residual = np.where(known, residual, 0.0)
        r = np.clip(np.nan_to_num(residual), -_CLIP, _CLIP)
        train, held, block = data.train[name] & known, data.held[name] & known, data.blocks[name]
        if train.sum() < 60 or float(np.mean(r[train] ** 2)) < _AT_THE_FLOOR:
            continue
        count = len(data.split.held)

        def told(law: str, gains: Array, name: str = name, train: Mask = train, held: Mask = held,
                 block: NDArray[np.int64] = block, count: int = count, most: float = np.inf) -> Uneven:  # fmt: skip
            blocks = np.bincount(block[held], gains[held], count).astype(np.float64)
            return Uneven(name, law, float(gains[train].sum()), blocks, most=most)

        if name != "joint_position" or last.sigma[name] > _ROUNDED * _step(last.world.channels[name]):
            found.append(told(ON_ITS_PAST, _memory(r, train), most=1.0))
        if name in ("acceleration", "displacement", "deflection"):
            found.append(told("the arm is driven at its own frequency", _driven(data, last, name, r, train)))
        if name in ("acceleration", "deflection"):
            counts = known & ~unpredictable(data, last)[block]
            gains = steady_spectrum(r, counts, block, count)
            found.append(Uneven(name, ITS_SPECTRUM_STAYS, float(gains.sum()), gains, everywhere=True))
        lasting = pulses(data, outliers(data, last)) if name == "acceleration" else None
        if lasting is not None:
            found.append(Uneven(name, LASTING, float(lasting.sum()), lasting, everywhere=True))
        if name not in ENCODER:
            found += [
                told(law, gains, most=most) for law, gains, most in _variances(data, last, name, r, train)
            ]
    return found


def _step(values: Array) -> float:
    """The least by which successive values differ, if they do."""
    steps = np.abs(np.diff(values[np.isfinite(values)]))
    return float(np.min(steps, initial=np.inf, where=steps > _NO_STEP))


def _memory(r: Array, train: Mask) -> Array:
    """Linear prediction from the last twelve values, and from twelve means of eight before them."""
    means = lfilter(np.full(8, 0.125), [1.0], r)
    past = [np.concatenate((np.zeros(lag), r[:-lag])) for lag in range(1, _LAGS + 1)]
    past += [
        np.concatenate((np.zeros(lag), means[:-lag]))
        for lag in range(_LAGS + 1, _LAGS + 1 + 8 * _LAGS, 8)
        if lag < len(r) // 4
    ]
    x = np.stack(past, axis=1)
    gram = x[train].T @ x[train] + 0.02 * train.sum() * np.eye(x.shape[1])
    guess = x @ np.linalg.solve(gram, x[train].T @ r[train])
    v0 = float(np.mean(r[train] ** 2))
    v1 = max(float(np.mean((r - guess)[train] ** 2)), 1e-9)
    gains: Array = 0.5 * (r**2 / v0 - (r - guess) ** 2 / v1) + 0.5 * np.log(v0 / v1)
    return gains


@njit(cache=True, nogil=True)
def _phasor_filter(r: Array, known: Mask, turn: Array, stay: Array, drive: float, out: Array) -> None:
    """Log-likelihood of each value if a vibration, kept up by white force, lies in unit noise."""
    x0, x1, p00, p01, p11 = 0.0, 0.0, drive, 0.0, drive
    for k in range(r.shape[0]):
        c, s = np.cos(turn[k]) * stay[k], np.sin(turn[k]) * stay[k]
        x0, x1 = c * x0 - s * x1, s * x0 + c * x1
        a00 = c * c * p00 - 2 * c * s * p01 + s * s * p11
        a11 = s * s * p00 + 2 * c * s * p01 + c * c * p11
        a01 = c * s * (p00 - p11) + (c * c - s * s) * p01
        added = drive * (1.0 - stay[k] * stay[k])
        p00, p01, p11 = a00 + added, a01, a11 + added
        out[k] = 0.0
        if known[k]:
            v = p00 + 1.0
            e = r[k] - x0
            out[k] = -0.5 * (e * e / v + np.log(v)) + 0.5 * r[k] * r[k]
            g0, g1 = p00 / v, p01 / v
            x0 += g0 * e
            x1 += g1 * e
            p11 -= g1 * p01
            p01 -= g0 * p01
            p00 -= g0 * p00


def _driven(data: Data, last: Fit, name: str, r: Array, train: Mask) -> Array:
    """The likeliest level and correlation time of a vibration at the first mode's frequency."""
    w = 2.0 * pi * last.value("modes.0.frequency_hz")
    times = last.world.instants(last.vector) if name == "displacement" else last.world.cycle_times
    gap = np.abs(np.diff(times, prepend=times[0]))
    known = np.isfinite(last.residuals[name]) & np.isfinite(gap)
    gap = np.nan_to_num(gap)
    scale = 1.0 / max(float(np.sqrt(np.mean(r[train] ** 2))), 1e-9)
    best: tuple[float, Array] | None = None
    per_s = len(r) / max(float(times[-1] - times[0]), 1e-3)
    for settle_s in (0.3, 1.0, 4.0):
        for strength in (0.3, 1.0, 3.0, 10.0, 40.0):
            out = np.empty(len(r))
            drive = strength / (per_s * settle_s)
            _phasor_filter(r * scale, known, w * gap, np.exp(-gap / settle_s), drive, out)
            nats = float(out[train].sum())
            if best is None or nats > best[0]:
                best = (nats, out)
    assert best is not None
    return best[1]


def _variances(data: Data, last: Fit, name: str, r: Array, train: Mask) -> list[tuple[str, Array, float]]:
    """Level of the scatter by bins of what may drive it: the law, nats of each value, and the highest level."""
    world, motion = last.world, last.predicted.motion
    at = world.instants(last.vector) if name in FRAME_CHANNELS else world.cycle_times

    def seen(values: Array) -> Array:
        return np.interp(at, world.cycle_times, np.abs(values))

    square = r * r

    def before(width: int) -> Array:
        stay = float(np.exp(-1.0 / width))
        mean = lfilter([1.0 - stay], [1.0, -stay], square)
        return np.concatenate(([0.0], mean[:-1]))

    drivers = {
        "the scatter comes in bursts": before(10),
        "the scatter comes in long bursts": before(80),
        "the scatter grows with the joint's velocity": seen(motion.joint[:, 1]),
        "the scatter grows with the joint's acceleration": seen(motion.joint[:, 2]),
        "the scatter grows with the tip's acceleration": seen(motion.tip_acceleration),
        "the scatter grows with the tip's speed": seen(np.gradient(motion.tip)),
        "the scatter depends on the time": at - at[0],
    }
    found = []
    for law, driver in drivers.items():
        edges = np.unique(np.quantile(driver[train], np.linspace(0.0, 1.0, _BINS + 1)[1:-1]))
        if law.startswith("the scatter comes"):
            edges = np.unique(np.quantile(driver[train], (0.5, 0.8, 0.93, 0.98)))
        if not len(edges):
            continue
        group = np.searchsorted(edges, driver)
        total = float(np.mean(square[train]))
        sums = np.bincount(group[train], square[train], len(edges) + 1)
        counts = np.bincount(group[train], minlength=len(edges) + 1)
        levels = (sums + 10.0 * total) / (counts + 10.0)
        level = levels[group]
        nats = 0.5 * np.log(total / level) + 0.5 * square * (1.0 / total - 1.0 / level)
        found.append((law, nats, float(np.sqrt(levels.max()))))
    return found
