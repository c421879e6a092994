"""A periodic force whose size and phase take a course of their own: a machine that is loaded, speeds up and slows down.

    q_1'' = ... + c(t) cos(2 pi f t) + s(t) sin(2 pi f t)

f is a peak of what is left, away from what the arm does by itself: near its own frequency, or an overtone of that, any
error of the model looks like a force that wanders.
"""

from dataclasses import replace

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
    own_frequencies_hz,
    shown_of,
    steady_wave,
)
from stillarm.diagnosis.forms.swelling_wave import phasor_of, wave_columns
from stillarm.diagnosis.physics.space import Added

Array = NDArray[np.float64]

_GROUP = "wandering"
_PEAKS = 2  # of a channel's residual, the largest
_OF_ITSELF = 0.15  # of a mode's frequency, or of its overtones', within which the arm rings of itself
_LEAST_HZ = 0.5  # twice what a course of its size and phase is wide: a slower wave is no wave but that course
_STEADY = 0.8  # of what a wave that wanders takes away: one that stays as it is takes less
_STILL_THERE, _GOES_ON = 0.4, 0.95  # of its size; of the time since it began, in which it is larger


def _added(fit: Fit) -> tuple[Added, ...]:
    of_steady = {
        hz: nats_taken(fit, shown_of(fit, steady_wave(fit, hz)), OF_A_WAVE)[0] for hz in _peaks_hz(fit)
    }
    if not of_steady:
        return ()
    hz = max(of_steady, key=lambda one: of_steady[one])
    force = wave_columns(fit.world.cycle_times, fit.world.measured.duration_s, hz)
    columns = shown_of(fit, force)
    (whole,) = nats_taken(fit, columns, force.shape[1])
    if whole < CONVINCING_NATS or of_steady[hz] > _STEADY * whole:
        return ()
    return (Added(_GROUP, columns, amount_std(fit), over_time=True, hz=hz),)


def _peaks_hz(fit: Fit) -> list[float]:
    """Frequencies at which most is left of a channel, and the arm does not ring of itself."""
    own, highest = own_frequencies_hz(fit), highest_hz(fit)
    found: list[float] = []
    for peaks in residual_peaks(fit).values():
        apart = [
            hz
            for hz in peaks
            if _LEAST_HZ < hz < highest and all(abs(hz / one - 1.0) > _OF_ITSELF for one in own)
        ]
        found += apart[:_PEAKS]
    return list(dict.fromkeys(found))


def _phasor(fit: Fit) -> NDArray[np.complex128]:
    """Of the wave that was fitted, (cycles,), m/s^2."""
    one, world = group_of(fit, _GROUP), fit.world
    amounts = np.array([fit.value(each) for each in one.amounts])
    return phasor_of(amounts, world.cycle_times, world.measured.duration_s)


def _size(phasor: NDArray[np.complex128]) -> float:
    """The size where the force acts, m/s^2: weighted by its power."""
    power = np.abs(phasor) ** 2
    return float(np.sqrt(np.sum(power**2) / max(float(power.sum()), 1e-300)))


def _values(fit: Fit) -> Values:
    """The size that it has where it acts, and the mean frequency there, weighted by the wave's power."""
    phasor = _phasor(fit)
    turns = (np.conj(phasor) * np.gradient(phasor, fit.world.measured.cycle_s)).imag
    rate = float(turns.sum()) / max(float(np.sum(np.abs(phasor) ** 2)), 1e-300)
    hz = group_of(fit, _GROUP).hz + rate / (2.0 * np.pi)
    return {"frequency_hz": (hz, 0.0), "amplitude_m_s2": (_size(phasor), 0.0)}


def _lasts(fit: Fit) -> bool:
    """Whether it goes on once it has begun: a resonance of the stand, or across the axis, rings down from every
    move."""
    phasor = _phasor(fit)
    there = np.abs(phasor) > _STILL_THERE * _size(phasor)
    return float(np.mean(there[int(np.argmax(there)) :])) > _GOES_ON


_TERMS: Form = of_terms(
    "periodic_disturbance", "whose size and phase wander", arm_moves, _GROUP, _values, _added
)
FORM = replace(_TERMS, cause=replace(_TERMS.cause, possible=_lasts))
