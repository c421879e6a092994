"""Input shaping of the external joint reference [5, 6], so that a move does not excite the first mode.

ZV (zero vibration) replaces the reference by the sum of two copies half a damped period apart, in the proportion 1 : K
with K = exp(-zeta pi / sqrt(1 - zeta^2)). The second copy cancels the vibration from the first. ZVD (zero derivative by
the frequency as well) is ZV applied twice: 1 : 2K : K^2 (Singer and Seering, J. Dyn. Syst. Meas. Control 112, 1990).

Half a period is not a whole number of cycles. The second copy is therefore split between the cycles before and after
it, with amplitudes that make the vibration exactly zero: the filter has a zero at exp(s cycle_s), s the mode's pole
(Murphy and Watanabe, J. Guidance, Control and Dynamics 15, 1992).
"""

from cmath import exp
from math import floor, pi, sqrt
from typing import Literal

import numpy as np

from stillarm.common.files.model import Mode
from stillarm.controller.joint.history import CycleHistory

Tap = tuple[int, float]  # cycles of delay, amplitude


def zv_taps(mode: Mode, cycle_s: float) -> list[Tap]:
    """Delays in cycles and amplitudes of the zero-vibration shaper; the amplitudes add up to 1."""
    w, zeta = mode.angular_frequency, mode.damping_ratio
    damped = w * sqrt(1.0 - zeta * zeta)
    whole = floor(pi / damped / cycle_s)
    pole = complex(-zeta * w, damped) * cycle_s
    before, after = exp(-pole * whole), exp(-pole * (whole + 1))
    conditions = np.array(((1.0, 1.0, 1.0), (1.0, before.real, after.real), (0.0, before.imag, after.imag)))
    amplitudes = np.linalg.solve(conditions, np.array((1.0, 0.0, 0.0)))
    taps = zip((0, whole, whole + 1), (float(a) for a in amplitudes), strict=True)
    return [(delay, amplitude) for delay, amplitude in taps if abs(amplitude) > 1e-12]


def zvd_taps(mode: Mode, cycle_s: float) -> list[Tap]:
    """The zero-vibration shaper applied twice, which tolerates an error of the frequency."""
    once = zv_taps(mode, cycle_s)
    twice: dict[int, float] = {}
    for first, a in once:
        for second, b in once:
            twice[first + second] = twice.get(first + second, 0.0) + a * b
    return sorted(twice.items())


class ReferenceShaper:
    """Shapes one signal, cycle by cycle. Causal: it responds at once, and ends half a period (ZVD: a period) later."""

    def __init__(self, shaping: Literal["none", "zv", "zvd"], mode: Mode, cycle_s: float) -> None:
        """mode: must not be excited; the shaping "none" passes the reference through."""
        taps: list[Tap] = [(0, 1.0)]
        if shaping != "none":
            taps = zv_taps(mode, cycle_s) if shaping == "zv" else zvd_taps(mode, cycle_s)
        self._taps = taps[1:]
        self._first = taps[0][1]
        self._history = CycleHistory(taps[-1][0] + 1)

    def restart(self) -> None:
        """Forget pending copies: the reference before the next cycle counts as zero."""
        self._history.clear()

    def shape(self, cycle: int, reference: float) -> float:
        """The shaped reference of a cycle. The reference before the first cycle counts as zero.

        Skipped cycles count with the reference of the cycle after them.
        """
        if not self._taps:
            return reference
        self._history.write(cycle, reference)
        total = self._first * reference
        for delay, amplitude in self._taps:
            total += amplitude * self._history.at(float(cycle - delay))
        return total
