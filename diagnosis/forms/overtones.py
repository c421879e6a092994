"""A periodic force whose wave is no sine, as a machine's: with its overtones.

    q_1'' = ... + sum over k = 1 ... 3 of  c_k cos(2 pi k f t) + s_k sin(2 pi k f t)

f is a peak of what is left; by how much it is off there is told by terms that grow with time (force_terms.py).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.fitting.evidence import CONVINCING_NATS
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.fitting.peaks import residual_peaks
from stillarm.diagnosis.forms.cause import Form, Values, arm_moves
from stillarm.diagnosis.forms.courses import group_of, of_terms
from stillarm.diagnosis.forms.force_terms import (
    OF_A_WAVE,
    amount_std,
    highest_hz,
    nats_taken,
    shown_of,
    steady_wave,
)
from stillarm.diagnosis.physics.space import Added
from stillarm.diagnosis.physics.world import World

Array = NDArray[np.float64]

_GROUP = "overtones"
_ORDERS = (1, 2, 3)  # of the wave: what an arm answers falls with the square of the frequency
_TOLD = 0.1  # of what a wave takes away, that its first order, and its overtones, are to take at least
_PEAKS = 8  # of a channel's residual, the largest


@dataclass(frozen=True)
class _Wave:
    """Terms by channel; nats that its first order takes away, and all of them."""

    hz: float
    columns: dict[str, Array]
    first: float
    whole: float


def _added(fit: Fit) -> tuple[Added, ...]:
    best = max(_waves(fit), key=lambda one: one.whole, default=None)
    if best is None or best.whole - best.first < max(CONVINCING_NATS, _TOLD * best.whole):
        return ()
    return (Added(_GROUP, best.columns, amount_std(fit), hz=best.hz),)


def _waves(fit: Fit) -> Iterator[_Wave]:
    """Of each peak; but for those whose first order tells nothing: the peak is an overtone of another."""
    peaks = dict.fromkeys(hz for of_one in residual_peaks(fit).values() for hz in of_one[:_PEAKS])
    for hz in peaks:
        if max(_ORDERS) * hz > highest_hz(fit):
            continue
        force = np.concatenate([steady_wave(fit, order * hz) for order in _ORDERS], axis=1)
        columns = shown_of(fit, force)
        first, whole = nats_taken(fit, columns, OF_A_WAVE, force.shape[1])
        if first > _TOLD * whole:
            yield _Wave(hz, columns, first, whole)


def _values(fit: Fit) -> Values:
    """Frequency and size of the first order, in the middle of the recording."""
    one = group_of(fit, _GROUP)
    cosine, sine, cosine_grows, sine_grows = (fit.value(each) for each in one.amounts[:OF_A_WAVE])
    size = float(np.hypot(cosine, sine))
    # rad by which it comes to lag from the middle to the end
    turns = (cosine * sine_grows - sine * cosine_grows) / max(size * size, 1e-300)
    hz = one.hz - turns / (2.0 * pi * _middle_s(fit.world))
    return {"frequency_hz": (hz, 0.0), "amplitude_m_s2": (size, 0.0)}


def _middle_s(world: World) -> float:
    return 0.5 * world.measured.duration_s


FORM: Form = of_terms("periodic_disturbance", "with its overtones", arm_moves, _GROUP, _values, _added)
