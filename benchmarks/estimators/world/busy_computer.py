"""How late a busy computer delivers images: an earliest moment, a queue, stalls, and a start with a backlog.

Frame k is handed over at h_k = e_k + max(earliest, delay + slow_k) + scheduling_k. One process tracks and sends the
images in turn (a queue with one server: D. V. Lindley, Proc. Cambridge Phil. Soc. 48, 1952):

    done_k = max(h_k, done_{k-1}, end of a stall) + service_k

At the start the process has a backlog and serves images at the rate of their arrival. The queue does not shrink before
service becomes faster; then it drains by the difference at each image.
"""

from math import exp

import numpy as np
from numpy.typing import NDArray

from stillarm.benchmarks.estimators.world.regimes import FRAME_S, Busy

Values = NDArray[np.float64]
Counts = NDArray[np.int64]


def passed_on(
    law: Busy, exposed_s: Values, delay_s: float, slow_s: Values, random: np.random.Generator
) -> tuple[Counts, Values, Values]:
    """The frames that are not lost: indices, the time at which each is done, and its n_i as a time. Shapes (kept,).

    delay_s: mean of done - exposed while the process keeps up. slow_s: slow part of the delay, shape (frames,).
    """
    count = len(exposed_s)
    mean = delay_s + law.mean_std_s * random.standard_normal()
    before = mean - law.scheduling_s - law.service_s - law.service_tail_s
    handed = (
        exposed_s
        + np.maximum(law.earliest_s, before + slow_s)
        + random.gamma(2.0, 0.5 * law.scheduling_s, count)
    )
    service = _service_s(law, count, random)
    stalls = _stalls_s(law, float(exposed_s[-1]), random)
    free = float(handed[0]) + random.uniform(*law.started_behind_s)
    places: list[int] = []
    done: list[float] = []
    began: list[float] = []
    for k in range(count):
        waiting = sum(one > handed[k] for one in began[-law.buffers - 1 :])
        if waiting >= law.buffers:
            continue
        begin = max(float(handed[k]), free)
        for from_s, to_s in stalls:
            begin = to_s if from_s <= begin < to_s else begin
        free = begin + service[k]
        places.append(k)
        began.append(begin)
        done.append(free)
    ends = np.array(done)
    asked = np.concatenate((np.full(min(law.in_flight, len(ends)), exposed_s[0]), ends[: -law.in_flight]))
    return np.array(places, dtype=np.int64), ends, asked


def _service_s(law: Busy, count: int, random: np.random.Generator) -> Values:
    """Service time of each frame: at first FRAME_S on average with exponential spread, later short."""
    warm = int(random.integers(*law.warm_frames))
    cold = np.array([1.0 if k < warm else exp(-(k - warm) / law.warm_up_frames) for k in range(count)])
    tail = law.service_tail_s + cold * (FRAME_S - law.service_s - law.service_tail_s)
    return np.asarray(law.service_s + tail * random.standard_exponential(count))


def _stalls_s(law: Busy, until_s: float, random: np.random.Generator) -> list[tuple[float, float]]:
    """Intervals in which the process does not run."""
    starts = np.sort(random.uniform(0.0, until_s, random.poisson(law.stalls_per_s * until_s)))
    return [(float(start), float(start + random.uniform(*law.stall_s))) for start in starts]
