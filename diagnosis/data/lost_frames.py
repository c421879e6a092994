"""How many frames were lost before each one that came, where the counter counts arrivals: a search with a beam.

    received_k = T n_k + level_k + noise,   level = base + slope t + wander,   n_k - n_{k-1} = 1 + lost_k

A lost frame leaves all later ones late by a whole period for good; a burst of late frames ends, and a wander is slow.
Each hypothesis carries the number of frames lost so far, whether it is in a burst, and a Kalman filter of the level
(Bar-Shalom, Li and Kirubarajan, Estimation with Applications, 2001, chapters 5 and 11); of those with equal number and
burst only the best goes on, so that what is found is the likeliest path of the beam (Viterbi).
"""

from math import log, sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stillarm.diagnosis.data.robust import std_about_median, std_about_zero

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

_WIDTH = 24  # hypotheses that go on from a frame: time grows with them
_FURTHER_NATS = 1.1  # each further lost frame of a run
_ENTER_NATS, _EARLY_NATS, _LEAVE_NATS, _STAY_NATS = 4.0, 16.0, 2.0, 0.003  # a burst, or a clock that was set
_JUMP = 3.0  # deviation of a burst's lateness, periods
_MOST_NATS, _HUBER, _FAR = 7.0, 3.0, 5.0  # one frame's surprise; deviations
_BEAM_NATS = 25.0  # behind the best hypothesis, at which another is dropped: e^25 to 1
_SLOPE = 3e-3  # deviation of skew and drift, s/s
_USUAL_LOSS = 0.01  # of the frames: the first pass's; the second takes the rate that the first finds
_WANDER_S = 2.0  # correlation time of the delay's wander in the search; its strength is tried
# intervals' scatter, and that off whole periods (0.26 where no number of them is likelier), periods
_BLURRED = ((0.3, 0.22), (0.45, 0.19))
_NEVER_NATS = 1e6  # a loss in the path without any: over 140 000 of the costliest frames (_MOST_NATS)
_LEAST_NATS = 0.0  # by which losses have to explain the arrivals better than a wander and bursts alone


def lost_before(received_s: Array, step: Counts, period_s: float) -> Counts:
    """Frames lost before each frame (0 for the first). step: the counter's own steps, len(received_s) - 1.

    None where the frames scatter so far that their intervals are no whole periods any more: a frame that is late and
    one that comes after a lost one look alike then.
    """
    passed = np.diff(received_s) / period_s - step
    nothing = np.zeros(len(received_s), np.int64)
    white = _quick(passed) * period_s
    if len(received_s) < 4 or float(np.max(passed)) < min(0.5, 1.0 - 3.0 * white / period_s):
        return nothing
    apart = scatter(received_s, step, period_s)
    if any(apart > most and white > off * period_s for most, off in _BLURRED):
        return nothing
    found, share, cost = nothing, _USUAL_LOSS, 0.0
    for _ in range(2):
        cost, found = _search(received_s, step, period_s, white, -log(share), -log(1.0 - share))
        share = min(max(float(np.mean(found > 0)), 0.002), 0.5)
    without, _ = _search(received_s, step, period_s, white, _NEVER_NATS, 0.0)
    return found if without - cost > _LEAST_NATS else nothing


def _search(
    received_s: Array, step: Counts, period_s: float, white: float, open_nats: float, none_nats: float
) -> tuple[float, Counts]:
    """Cost and path of the likelier of two strengths of the wander."""
    tries = []
    for wander in (1.0, 3.0):
        lost = np.zeros(len(received_s), np.int64)
        strength = max(wander * white, 0.03 * period_s)
        cost = _likeliest(received_s, step, period_s, white, strength, _WANDER_S, open_nats, none_nats, lost)
        tries.append((cost, lost))
    return min(tries, key=lambda one: one[0])


def scatter(times_s: Array, step: Counts, period_s: float) -> float:
    """Deviation of what changes from frame to frame, in periods, as far as fewer than half of the frames were lost."""
    return std_about_median(np.diff(times_s) / period_s - step) / sqrt(2.0)


def _quick(passed: Array) -> float:
    """Deviation of what changes from frame to frame, in periods, whatever was lost: whole periods are taken off."""
    rest = passed - np.rint(passed)
    return max(std_about_zero(rest) / sqrt(2.0), 0.01) if len(rest) else 0.01


@njit(cache=True, nogil=True)
def _likeliest(  # noqa: PLR0912, PLR0915  (one compiled loop)
    received: Array, step: Counts, period: float, white: float, wander: float, time_s: float,
    open_nats: float, none_nats: float, lost: Counts,
) -> float:  # fmt: skip
    """Fill `lost` by the likeliest path; its cost, nats."""
    n, noise, sudden = received.shape[0], white * white, (_JUMP * period) ** 2
    most = 10 * _WIDTH
    # of each hypothesis: wander, base, slope, the burst's lateness, s; and their covariance
    mean, new_mean = np.zeros((_WIDTH, 4)), np.zeros((most, 4))
    var, new_var = np.zeros((_WIDTH, 4, 4)), np.zeros((most, 4, 4))
    cost, new_cost = np.zeros(_WIDTH), np.zeros(most)
    # frames lost so far; 1 in a burst; and where each came from
    label, new_label = np.zeros((_WIDTH, 2), np.int64), np.zeros((most, 2), np.int64)
    origin, new_origin = np.zeros((n, _WIDTH, 2), np.int32), np.zeros((most, 2), np.int32)
    var[0, 0, 0], var[0, 1, 1], var[0, 2, 2] = wander**2, 4.0 * noise + wander**2, _SLOPE**2
    x, p, gain, alive, due = np.zeros(4), np.zeros((4, 4)), np.zeros(4), 1, received[0]
    for k in range(1, n):
        due += step[k - 1] * period
        count, least = 0, np.inf
        for h in range(alive):
            late = received[k] - due - label[h, 0] * period - mean[h, 0] - mean[h, 1]
            near, beyond = round(late / period), round((late - mean[h, 3]) / period)
            for choice in range(5):
                j = 0 if choice == 0 else (near + choice - 2 if choice < 4 else beyond)
                if choice > 0 and (j < 1 or (choice == 4 and abs(beyond - near) <= 1)):
                    continue
                for burst in range(2):
                    c = cost[h] + (none_nats if j == 0 else open_nats + _FURTHER_NATS * min(j - 1, 12))
                    x[:], p[:] = mean[h], var[h]
                    was = label[h, 1]
                    if was == 1 and burst == 0:
                        c += _LEAVE_NATS
                        x[3], p[3, :], p[:, 3] = 0.0, 0.0, 0.0
                    elif was == 0 and burst == 1:
                        p[3, 3] = sudden
                    elif burst == 1:
                        c += _STAY_NATS
                    _ahead((step[k - 1] + j) * period, wander, time_s, x, p)
                    off = received[k] - due - (label[h, 0] + j) * period - x[0] - x[1] - x[3]
                    if was == 0 and burst == 1:
                        c += _ENTER_NATS if off > 0.0 else _EARLY_NATS
                    c += _taken(off, noise, x, p, gain)
                    if c > least + _BEAM_NATS:
                        continue
                    least = min(least, c)
                    # one best of each number and burst
                    at = count
                    for other in range(count):
                        if new_label[other, 0] == label[h, 0] + j and new_label[other, 1] == burst:
                            at = other
                    if at == count:
                        count += 1
                    elif c >= new_cost[at]:
                        continue
                    new_mean[at], new_var[at], new_cost[at] = x, p, c
                    new_label[at, 0], new_label[at, 1] = label[h, 0] + j, burst
                    new_origin[at, 0], new_origin[at, 1] = h, j
        order = np.argsort(new_cost[:count])
        alive = 0
        for o in order[:_WIDTH]:
            if new_cost[o] > new_cost[order[0]] + _BEAM_NATS:
                break
            mean[alive], var[alive], cost[alive] = new_mean[o], new_var[o], new_cost[o]
            label[alive], origin[k, alive] = new_label[o], new_origin[o]
            alive += 1  # noqa: SIM113
    total, h = cost[0], 0
    for k in range(n - 1, 0, -1):
        lost[k] = origin[k, h, 1]
        h = origin[k, h, 0]
    return float(total)


@njit(cache=True, nogil=True)
def _ahead(t: float, wander: float, time_s: float, x: Array, p: Array) -> None:
    """The level t later."""
    stay = np.exp(-t / time_s)
    x[0] *= stay
    x[1] += t * x[2]
    p[0, :] *= stay
    p[1, :] += t * p[2, :]
    p[:, 0] *= stay
    p[:, 1] += t * p[:, 2]
    p[0, 0] += wander * wander * (1.0 - stay * stay)


@njit(cache=True, nogil=True)
def _taken(off: float, noise: float, x: Array, p: Array, gain: Array) -> float:
    """Take in one frame that is `off` from what was expected; its cost, nats: bounded, as is its weight."""
    gain[:] = p[:, 0] + p[:, 1] + p[:, 3]
    s = gain[0] + gain[1] + gain[3] + noise
    u = abs(off) / np.sqrt(s)
    if u < _FAR:
        weight = 1.0 if u < _HUBER else _HUBER / u
        x += weight * off / s * gain
        for i in range(4):
            for j in range(4):
                p[i, j] -= weight * gain[i] * gain[j] / s
    cost = 0.5 * u * u if u < _HUBER else _HUBER * u - 0.5 * _HUBER**2
    return float(min(cost, _MOST_NATS) + 0.5 * np.log(s / noise))
