"""Finds the columns that are derivatives of others.

If y = k dx/dt, then X = Y / (k i w) at every frequency w. The columns are compared as positions, so that a sensor's
noise, which the derivative would magnify, counts little:

    r = Re sum conj(Y / (i w)) X / sqrt(sum |Y / (i w)|^2 sum |X|^2)        over w above the first few bins

r = 1 for a derivative without noise, 0 for a copy (its phase is off by 90 degrees at every frequency). At one frequency
alone a delayed copy looks like a derivative, so the energy must spread, and k be the same in its lower and upper half.
"""

from dataclasses import dataclass

import numpy as np

from stillarm.tables.guesses.spectra import Spectra

FIRST_BIN = {1: 2, 2: 12}  # below: drift, and what the window adds
SURE = 0.97
SURE_TWICE = 0.93  # of a second derivative: two integrations leave more drift
_SAME_FACTOR = 1.35  # of k in the bands below and above the middle of the energy
_APART = 1.15  # ratio of the frequencies below which three quarters and one quarter of |X||Y| lie


@dataclass(frozen=True)
class Derivative:
    """column = factor * d^order(of)/dt^order, factor per second^order where the rate is known, else per sample."""

    column: str
    of: str
    factor: float
    match: float
    order: int = 1


def derivatives(spectra: Spectra, rate_hz: float | None) -> list[Derivative]:
    """Pairs a column with the column whose first or second derivative it is, where that is certain."""
    found = []
    for name in spectra.samples:
        options = [
            Derivative(name, other, *_compared(spectra, other, name, order), order)
            for other in spectra.samples
            if other != name
            for order in (1, 2)
        ]
        sure = [o for o in options if o.match > (SURE if o.order == 1 else SURE_TWICE)]
        if sure:
            best = max(sure, key=lambda option: option.match)
            scale = (rate_hz or 1.0) ** best.order
            found.append(Derivative(name, best.of, best.factor / scale, best.match, best.order))
    return found


def _compared(spectra: Spectra, state: str, rate: str, order: int) -> tuple[float, float]:
    """The factor k per sample^order, and r; r is 0 where only one frequency speaks."""
    first = FIRST_BIN[order]
    position = spectra.states[state] if order == 1 else spectra.windowed[state]
    velocity = spectra.rates[rate] if order == 1 else spectra.windowed[rate]
    x, w = position[first:], spectra.omega[first:]
    integral = velocity[first:] / (1j * w) ** order
    both = np.real(np.conj(integral) * x)
    size_x, size_y = np.abs(x) ** 2, np.abs(integral) ** 2
    norm = float(np.sqrt(size_x.sum() * size_y.sum()))
    if norm <= 0.0 or not np.isfinite(norm):
        return 0.0, 0.0
    match = float(both.sum()) / norm
    if abs(match) < SURE_TWICE:
        return 0.0, 0.0
    shared = np.sqrt(size_x) * np.abs(velocity[first:])
    energy = np.cumsum(shared) / shared.sum()
    quarters = [w[int(np.searchsorted(energy, share))] for share in (0.25, 0.75)]
    middle = max(1, int(np.searchsorted(energy, 0.5)))
    parts = [float(both[band].sum() / size_x[band].sum()) for band in (slice(0, middle), slice(middle, None))]
    ratio = abs(parts[1] / parts[0]) if parts[0] and np.isfinite(parts).all() else np.inf
    if quarters[1] < _APART * quarters[0] or not 1.0 / _SAME_FACTOR < ratio < _SAME_FACTOR:
        return 0.0, 0.0
    factor = float(both.sum() / size_x.sum())
    return factor, abs(match)
