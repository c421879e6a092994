"""A periodic force whose wave is no sine, as a machine's: with its overtones.

    q_1'' = ... + sum over k = 1 ... 3 of  c_k cos(2 pi k f t) + s_k sin(2 pi k f t)

f is a peak of what is left. By how much it is off there is told by terms that grow with time: c cos(2 pi (f + d) t) is,
to first order in d, c cos(2 pi f t) - 2 pi d c t sin(2 pi f t).
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
from stillarm.diagnosis.forms.freeform import answered_by_arm
from stillarm.diagnosis.physics.space import Added
from stillarm.diagnosis.physics.world import World

Array = NDArray[np.float64]

_GROUP = "overtones"
_SHOWN = ("acceleration", "displacement", "deflection")
_ORDERS = (1, 2, 3)  # of the wave: what an arm answers falls with the square of the frequency
_OF_A_WAVE = 4  # columns: cosine and sine, and both growing with time
_TOLD = 0.1  # of what a wave takes away, that its first order, and its overtones, are to take at least
_MOST_OF_RATE = 0.4  # a frequency over the cycles': a faster wave is none in samples
_PEAKS = 8  # of a channel's residual, the largest
_STD = 10.0  # of an amount, over what sways the arm, standing still, by as much as it does


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
    w = 2.0 * pi * fit.value("modes.0.frequency_hz")
    sways = w * w * float(np.std(fit.predicted.motion.q[:, 0])) or 1.0
    return (Added(_GROUP, best.columns, _STD * sways, hz=best.hz),)


def _waves(fit: Fit) -> Iterator[_Wave]:
    """Of each peak; but for those whose first order tells nothing: the peak is an overtone of another."""
    seen = residual_peaks(fit)
    peaks = dict.fromkeys(hz for name in _SHOWN for hz in seen.get(name, ())[:_PEAKS])
    for hz in peaks:
        if max(_ORDERS) * hz > _MOST_OF_RATE / fit.world.measured.cycle_s:
            continue
        answers = answered_by_arm(fit, _wave(fit, hz))
        columns = {name: answers[name] for name in _SHOWN if name in fit.world.channels}
        first, whole = _nats(fit, columns)
        if first > _TOLD * whole:
            yield _Wave(hz, columns, first, whole)


def _wave(fit: Fit, hz: float) -> Array:
    """Accelerations of the first mode of 1 m/s^2, (cycles, waves)."""
    time, middle = fit.world.cycle_times, _middle_s(fit.world)
    grows = time / middle - 1.0
    columns = []
    for order in _ORDERS:
        phase = 2.0 * pi * order * hz * time
        columns += [np.cos(phase), np.sin(phase), grows * np.cos(phase), grows * np.sin(phase)]
    return np.stack(columns, axis=1)


def _nats(fit: Fit, columns: dict[str, Array]) -> tuple[float, float]:
    """What a wave's first order takes away from white residuals, and what all of them do; all channels together."""
    many = _OF_A_WAVE * len(_ORDERS)
    products, with_rest = np.zeros((many, many)), np.zeros(many)
    for name, terms in columns.items():
        sensor = fit.channel(name)
        if sensor is None:
            continue
        known = np.isfinite(sensor.residual)
        of_noise = terms[known] / fit.sigma[name]
        products += of_noise.T @ of_noise
        with_rest += of_noise.T @ (sensor.residual[known] / fit.sigma[name])

    def taken(count: int) -> float:
        own = with_rest[:count]
        return 0.5 * float(own @ np.linalg.lstsq(products[:count, :count], own, rcond=None)[0])

    return taken(_OF_A_WAVE), taken(many)


def _values(fit: Fit) -> Values:
    """Frequency and size of the first order, in the middle of the recording."""
    one = group_of(fit, _GROUP)
    cosine, sine, cosine_grows, sine_grows = (fit.value(each) for each in one.amounts[:_OF_A_WAVE])
    size = float(np.hypot(cosine, sine))
    # rad by which it comes to lag from the middle to the end
    turns = (cosine * sine_grows - sine * cosine_grows) / max(size * size, 1e-300)
    hz = one.hz - turns / (2.0 * pi * _middle_s(fit.world))
    return {"frequency_hz": (hz, 0.0), "amplitude_m_s2": (size, 0.0)}


def _middle_s(world: World) -> float:
    return 0.5 * world.measured.duration_s


FORM: Form = of_terms("periodic_disturbance", "with its overtones", arm_moves, _GROUP, _values, _added)
