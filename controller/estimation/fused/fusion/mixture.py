"""The filters' mixture at the bank's instant: what the present is worked out from.

Implements Eqs. 40, 41, 43 of docs/fused.md.
"""

from typing import NamedTuple

import numpy as np

from stillarm.controller.estimation.fused.filters.laws import FILTERS
from stillarm.controller.estimation.fused.fusion.state import FusionState
from stillarm.controller.estimation.fused.learning.stated_scale import Stated, with_stated_scale


class Merged(NamedTuple):
    """The filters' common state: phasors, slow rates, 1/s, accelerometer bias, m, static deflection by a force, m, and
    the covariance of the phasors, with the force behind them where there may be one."""

    phasors: list[complex]
    slow: list[complex]
    bias: float
    bias_variance: float
    force: float
    covariance: list[list[float]]


class Mixture:
    """Weighs the filters by their probabilities, and by the model's word on the image's scale."""

    def __init__(self, state: FusionState, first_scale: float, stated_scale: Stated) -> None:
        """first_scale: the filters' variance of the scale's error beforehand; stated_scale: what the model says."""
        self._state = state
        self._first_scale, self._stated_scale = first_scale, stated_scale
        self._carried = np.eye(state.at.size)[[*range(2 * state.at.modes), state.at.force]]

    def phasor_noise(self) -> float:
        """Growth of the variance of each phasor component, m^2/s."""
        return float(self._state.evidence.weights @ self._state.phasor_noise())

    def merged(self, now_s: float) -> Merged:
        """Phasors at the bank's instant, with the covariance that they have at now_s for want of newer images."""
        state = self._state
        bank, at, w = state.bank, state.at, state.evidence.weights
        best = state.evidence.best
        if w[best] > state.assumed.update.clear:
            x, p = bank.x[best], bank.p[best]
        else:
            x = w @ bank.x
            d = bank.x - x
            p = (w @ bank.p.reshape(FILTERS, -1)).reshape(at.size, at.size) + (d * w[:, None]).T @ d
        if state.as_calibrated:
            x, p = with_stated_scale(
                x, p, at.scale, self._first_scale, self._stated_scale, state.assumed.scale
            )
        m = at.modes
        phasors: list[complex] = (x[at.cosine] - 1j * x[at.sine]).tolist()
        lag = now_s - bank.edge_s
        f = self._carried  # the rows of the phasors
        for i, one in enumerate(phasors):
            by_rate = lag * one
            c, s, kw, kd = 2 * i, 2 * i + 1, 2 * m + i, 3 * m + i
            f[c, kw], f[s, kd] = -by_rate.imag, by_rate.imag
            f[s, kw] = f[c, kd] = -by_rate.real
        rows = 2 * m + int(state.held_force.active)
        f = f[:rows]
        covariance: list[list[float]] = (f @ p @ f.T).tolist()
        noise = self.phasor_noise() * lag
        for i in range(2 * m):
            covariance[i][i] += noise
        state.amplitude_m = sum([abs(one) for one in phasors])
        slow: list[complex] = (-at.sigma - x[at.decay] + 1j * x[at.frequency]).tolist()
        bias = float(x[at.bias]), float(p[at.bias, at.bias])
        return Merged(phasors, slow, *bias, float(x[at.force]), covariance)
