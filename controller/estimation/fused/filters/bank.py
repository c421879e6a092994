"""Extended Kalman filters side by side, one for each law by which a frame may be dated: their states.

Implements Eqs. 6, 29 of docs/fused.md.

All live at one instant `edge_s`, the end of the last accelerometer block they have processed, which lies about a
capture delay back: an image is processed at its own instant, and the accelerometer's later blocks are added afterwards
(present.py). The modules beside it change the states: block_update, image_update, date_update, jumps, new_beginning.
"""

import numpy as np

from stillarm.controller.estimation.fused.arm.layout import Layout
from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions
from stillarm.controller.estimation.fused.filters.laws import FILTERS, Array, ComplexArray


class FilterBank:
    """States x (filters, n), covariances p (filters, n, n).

    moved: how often each filter's frequencies and decay were changed or loosened otherwise than by a measurement.
    """

    def __init__(
        self, layout: Layout, variance: Array, jitter_s: Array, assumed: Assumptions = ASSUMPTIONS
    ) -> None:
        """variance: (filters, n) at the start; jitter_s: white spread of each law's instants, s, (filters,)."""
        self.at = layout
        self.assumed = assumed
        self.diagonal = np.arange(layout.size)
        self.forced = [0, 1, layout.force]  # the first mode's phasor, and the force that it vibrates about
        self.move = np.eye(layout.size)[None, : 2 * layout.modes].repeat(FILTERS, axis=0)
        self.moved = [0] * FILTERS
        self.first, self.first_jitter = variance, jitter_s**2
        self.begin()
        self.edge_s = 0.0
        self.iw, self.minus_sigma = 1j * layout.w, -layout.sigma
        self.image_gain = layout.image_gain.astype(np.complex128)
        self.w_modes = layout.w
        self.w, self.sigma = layout.w.tolist(), layout.sigma.tolist()
        self.per_acceleration = -1.0 / layout.w_first**2

    def begin(self) -> None:
        """As at the start: all states zero."""
        n = self.at.size
        self.x = np.zeros((FILTERS, n))
        self.p = np.zeros((FILTERS, n, n))
        self.p[:, self.diagonal, self.diagonal] = self.first
        self.jitter = self.first_jitter
        self.all_moved()

    def all_moved(self) -> None:
        self.moved = [one + 1 for one in self.moved]

    def phasors(self) -> ComplexArray:
        """Z = a - i b of each mode, (filters, m): mode i deflects Re(Z exp(i w t))."""
        pairs: ComplexArray = self.x[:, self.at.phasor].view(np.complex128)
        return pairs.conj()

    def slow_rates(self) -> ComplexArray:
        """Slow complex rate of each phasor, (filters, m)."""
        at = self.at
        rates = np.empty((FILTERS, at.modes), dtype=np.complex128)  # parts: mixed types cost twice as much
        np.subtract(self.minus_sigma, self.x[:, at.decay], out=rates.real)
        rates.imag = self.x[:, at.frequency]
        return rates

    def symmetrise(self) -> None:
        """Make the covariances symmetric; rounding in each measurement update makes them slightly asymmetric."""
        self.p = 0.5 * (self.p + self.p.transpose(0, 2, 1))

    def first_variance(self, one: int, index: int) -> float:
        """Variance of a state of filter `one` at the start."""
        return float(self.first[one, index])

    def zero_variance(self, one: int, held_m: float) -> float:
        """Variance, m^2, of what an image shows by filter `one` of a tip at rest that the joint holds at held_m."""
        p, c, e = self.p[one], self.at.offset, self.at.scale
        return float(p[c, c] + held_m * (2.0 * p[c, e] + held_m * p[e, e]))

    def fast_rates(self) -> ComplexArray:
        """Complex rate of each mode by each filter, slow + i w, 1/s, (filters, m)."""
        return self.slow_rates() + self.iw
