"""Forces on the first mode as terms: what the arm's sensors show of them, and how much of a rest they take away."""

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.freeform import answered_by_arm

Array = NDArray[np.float64]

OF_A_WAVE = 4
"""Columns of a steady wave: cosine and sine, and both growing with time."""
_SHOWN = ("acceleration", "displacement", "deflection")
_MOST_OF_RATE = 0.4  # a frequency over the cycles': a faster wave is none in samples
_STD = 10.0  # of an amount, over what sways the arm, standing still, by as much as it does
_OVERTONES = (1, 2, 3)
"""A force that is even or odd in the deflection has these, at the least order that is no linear one."""


def steady_wave(fit: Fit, hz: float) -> Array:
    """A force of 1 m/s^2 that stays as it is but for its frequency, (cycles, 4).

    By how much that is off is told by the terms that grow with time: c cos(2 pi (f + d) t) is, to first order in d,
    c cos(2 pi f t) - 2 pi d c t sin(2 pi f t).
    """
    time = fit.world.cycle_times
    phase, grows = 2.0 * np.pi * hz * time, 2.0 * time / fit.world.measured.duration_s - 1.0
    cosine, sine = np.cos(phase), np.sin(phase)
    return np.stack([cosine, sine, grows * cosine, grows * sine], axis=1)


def shown_of(fit: Fit, force: Array) -> dict[str, Array]:
    """What the measured channels show of forces on the first mode, (cycles, k) m/s^2."""
    answers = answered_by_arm(fit, force)
    return {name: answers[name] for name in _SHOWN if name in fit.world.channels}


def nats_taken(fit: Fit, columns: dict[str, Array], *counts: int) -> list[float]:
    """What the first so many terms, by channel, take away from white residuals; all channels together."""
    many = next(iter(columns.values())).shape[1]
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

    return [taken(count) for count in counts]


def amount_std(fit: Fit) -> float:
    """The prior deviation of a force's amount, m/s^2."""
    w = 2.0 * np.pi * fit.value("modes.0.frequency_hz")
    return _STD * (w * w * float(np.std(fit.predicted.motion.q[:, 0])) or 1.0)


def highest_hz(fit: Fit) -> float:
    """Of a wave that is one in samples."""
    return _MOST_OF_RATE / fit.world.measured.cycle_s


def own_frequencies_hz(fit: Fit) -> list[float]:
    """At which the arm rings of itself: those of its modes, and their overtones."""
    modes = [fit.value(f"modes.{mode}.frequency_hz") for mode in range(fit.world.modes)]
    return [order * hz for hz in modes for order in _OVERTONES]
