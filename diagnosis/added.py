"""Terms without a formula of their own: columns that are added to what channels should show, in amounts to be fitted.

A course over time (a bias, an image zero, a gain) is a sum of hat functions; a force over the arm's state is answered
by its linear modes. Both are linear in their amounts, so that a fit has their derivatives at once.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Added:
    """One group of terms. columns: by channel, (samples, amounts). prior_std: of each amount."""

    name: str
    columns: Mapping[str, Array]
    prior_std: float

    @property
    def amounts(self) -> tuple[str, ...]:
        """The names of its quantities."""
        count = next(iter(self.columns.values())).shape[1]
        return tuple(f"{self.name}.{i}" for i in range(count))


def hats(time_s: Array, knots_s: Array) -> Array:
    """Hat functions, (samples, knots): each 1 at its knot, falling to 0 at its neighbours."""
    found = np.empty((len(time_s), len(knots_s)))
    for i in range(len(knots_s)):
        one = np.zeros(len(knots_s))
        one[i] = 1.0
        found[:, i] = np.interp(time_s, knots_s, one)
    return found


def answer_of_mode(
    force: Array, frequency_hz: float, damping_ratio: float, step_s: float
) -> tuple[Array, Array]:
    """Deflection, m, and its acceleration, m/s^2, of a mode under forces, (samples, k) m/s^2, from rest (bilinear)."""
    k, w = 2.0 / step_s, 2.0 * np.pi * frequency_hz
    a0 = k * k + 2.0 * damping_ratio * w * k + w * w
    a1, a2 = 2.0 * (w * w - k * k), k * k - 2.0 * damping_ratio * w * k + w * w
    b = np.array([1.0, 2.0, 1.0]) / a0
    q = lfilter(b, [1.0, a1 / a0, a2 / a0], force, axis=0)
    v = lfilter(np.array([1.0, 0.0, -1.0]) * k / a0, [1.0, a1 / a0, a2 / a0], force, axis=0)
    return q, force - 2.0 * damping_ratio * w * v - w * w * q
