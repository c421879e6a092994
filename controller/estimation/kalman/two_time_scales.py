"""The state model of the Kalman filters: fast modes, a slow imposed motion, and a sensor's offset.

State: q_1, q_1', ... q_M, q_M' (free vibration, m and m/s), c, c' (slow motion, in the metres that the image shows),
and the offset of a fast sensor, if one is fused. White accelerations drive the modes. A white c'' drives the slow
motion (an integrated random walk). The sensor's offset is a random walk.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.model import Mode
from stillarm.controller.estimation.kalman.mode_dynamics import ModeDynamics

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

_PRIOR_DEFLECTION_M = 0.1
_PRIOR_OFFSET_M = 0.3  # deviation of the image zero from the first sample
_PRIOR_SLOW_RATE_M_S = 0.02


class Densities(NamedTuple):
    """Spectral densities of the white noises: modes and slow motion m^2/s^3, sensor's offset (unit)^2/s."""

    modes: float
    slow: float
    sensor_offset: float


class TwoTimeScales:
    """Transition and process noise of the whole state over a time, and its prior. Shapes (size, size), (size,)."""

    def __init__(self, modes: list[Mode], densities: Densities, sensor_offset_std: float | None) -> None:
        """sensor_offset_std: prior deviation of a fast sensor's offset, in its unit; None without such a sensor."""
        self.modes = [ModeDynamics(mode) for mode in modes]
        self._densities = densities
        self._sensor_offset_std = sensor_offset_std
        self.slow = 2 * len(modes)
        self.size = self.slow + (2 if sensor_offset_std is None else 3)
        self.identity = np.eye(self.size)

    def transition(self, elapsed_s: float) -> Matrix:
        """The transition over a time of either sign."""
        phi = self.identity.copy()
        for i, mode in enumerate(self.modes):
            k = 2 * i
            phi[k, k], phi[k, k + 1], phi[k + 1, k], phi[k + 1, k + 1] = mode.transition(elapsed_s)
        phi[self.slow, self.slow + 1] = elapsed_s
        return phi

    def scatter(self, elapsed_s: float) -> Matrix:
        """Process noise: the covariance added over a time >= 0."""
        added = self.scatter_of_modes(elapsed_s) * self._densities.modes
        k, t, density = self.slow, elapsed_s, self._densities.slow
        added[k, k] = density * t * t * t / 3.0
        added[k, k + 1] = added[k + 1, k] = density * t * t / 2.0
        added[k + 1, k + 1] = density * t
        if self._sensor_offset_std is not None:
            added[k + 2, k + 2] = self._densities.sensor_offset * t
        return added

    def scatter_of_modes(self, elapsed_s: float) -> Matrix:
        """Process noise of a white acceleration of density 1 m^2/s^3 on each mode alone."""
        added = np.zeros((self.size, self.size))
        for i, mode in enumerate(self.modes):
            k = 2 * i
            added[k, k], added[k, k + 1], added[k + 1, k + 1] = mode.scatter(elapsed_s)
            added[k + 1, k] = added[k, k + 1]
        return added

    def prior_covariance(self) -> Matrix:
        """The prior before the first sample, wide in vibration, image zero and sensor offset."""
        first = self.modes[0].angular_frequency
        spread: list[float] = []
        for mode in self.modes:
            deflection = _PRIOR_DEFLECTION_M * (first / mode.angular_frequency) ** 2
            spread += [deflection, deflection * mode.angular_frequency]
        spread += [_PRIOR_OFFSET_M, _PRIOR_SLOW_RATE_M_S]
        if self._sensor_offset_std is not None:
            spread.append(self._sensor_offset_std)
        return np.diag(np.square(spread))
