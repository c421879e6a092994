"""Whether the accelerometer shows the vibration that images show, but at another phase: then the frames' dates are off.

A sensor that dies, clips, or changes its gain shows another amplitude; none shifts the phase. Dates that are off by d
shift what the images say of each instant by the phase w d, and leave the amplitude. So each block's value is regressed
on what the images say it should be, e, and on the same a quarter of a period on, e':

    value = r cos(phi) e + r sin(phi) e' + offset,      d = phi / w                                                (8.1)

Forgetting is exponential, over one and a half periods (weighted least squares).
"""

from math import atan2, hypot, sqrt

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_MEMORY_BLOCKS = 36.0
_FEWEST_BLOCKS = 12.0  # half a period, within which amplitude and offset cannot pass for a phase
_LEAST_RATIO, _LARGEST_RATIO = 0.7, 1.4  # r of a sensor that shows the vibration
_SIGNIFICANT = 6.0  # standard deviations of the phase
_LEAST_RAD = 0.15  # less is left to the filters, which follow it by themselves
_SUSPECT_BLOCKS = 4
_LARGEST_RAD = 2.9  # nearer to half a period, the sensor's sign is wrong
_LASTING_BLOCKS = (
    18  # three quarters of a period: what departs from the images behind an impact has no lasting phase
)


class DateWatch:
    """Watches the most likely filter.

    lag_rad: by how much dates are too late, as a phase of the vibration; 0 for none. suspected_rad: the same before it
    has lasted for long enough to be acted on.
    """

    def __init__(self) -> None:
        """Nothing compared yet."""
        self.restart()

    def restart(self) -> None:
        """Dates, arm or accelerometer have changed."""
        self._normal: Array = np.zeros((3, 3))
        self._right: Array = np.zeros(3)
        self._count = 0.0
        self._evident = 0
        self.lag_rad = self.suspected_rad = 0.0

    def see(self, value_m: float, expected_m: float, quadrature_m: float, variance: float) -> None:
        """A block's mean, without bias, beside what images say of its time and of a quarter of a period later.

        variance: of the difference, m^2.
        """
        keep, weight = 1.0 - 1.0 / _MEMORY_BLOCKS, 1.0 / variance
        row = np.array((expected_m, quadrature_m, 1.0))
        self._normal = keep * self._normal + np.outer(weight * row, row)
        self._right = keep * self._right + weight * value_m * row
        self._count = keep * self._count + 1.0
        phase = self._phase() if self._count > _FEWEST_BLOCKS else 0.0
        self._evident = self._evident + 1 if phase else 0
        self.suspected_rad = phase if self._evident >= _SUSPECT_BLOCKS else 0.0
        self.lag_rad = phase if self._evident >= _LASTING_BLOCKS else 0.0

    def _phase(self) -> float:
        """phi where it is significant, else 0."""
        if np.linalg.cond(self._normal) > 1e12:
            return 0.0
        inverse = np.linalg.inv(self._normal)
        in_phase, across, _ = (inverse @ self._right).tolist()
        ratio = hypot(in_phase, across)
        if not _LEAST_RATIO < ratio < _LARGEST_RATIO:
            return 0.0
        std = sqrt(max(float(inverse[1, 1]), float(inverse[0, 0]))) / ratio
        phase = atan2(across, in_phase)
        if abs(phase) > _LARGEST_RAD:
            return 0.0
        return phase if abs(phase) > max(_LEAST_RAD, _SIGNIFICANT * std) else 0.0
