"""Detects wrong dates: the accelerometer then shows the vibration that images show, but at another phase.

Implements Eq. 61 of docs/fused.md.

A sensor that dies, clips, or changes its gain shows another amplitude; none shifts the phase. Dates that are off by d
shift what the images say of each instant by the phase w d, and leave the amplitude. So each block's value is regressed
on what the images say it should be, e, and on the same a quarter of a period on, e':

    value = r cos(phi) e + r sin(phi) e' + offset,      d = phi / w                                                (61)

Forgetting is exponential, over one and a half periods (weighted least squares).
"""

from math import atan2, hypot, inf, sqrt

from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions


class DateWatch:
    """Watches the most likely filter.

    lag_rad: by how much dates are too late, as a phase of the vibration; 0 for none. suspected_rad: the same before it
    has lasted for long enough to be acted on.
    """

    def __init__(self, assumed: Assumptions = ASSUMPTIONS) -> None:
        """Nothing compared yet."""
        self._assumed = assumed.date_watch
        self.restart()

    def restart(self) -> None:
        """Dates, arm or accelerometer have changed."""
        self._sums = [0.0] * 9
        self._count = 0.0
        self._evident = 0
        self.lag_rad = self.suspected_rad = 0.0
        self._offset_stds = inf

    def see(self, value_m: float, expected_m: float, quadrature_m: float, variance: float) -> None:
        """A block's mean, without bias, beside what images say of its time and of a quarter of a period later.

        variance: of the difference, m^2.
        """
        e, q, v, weight = expected_m, quadrature_m, value_m, 1.0 / variance
        terms = (1.0, e, q, v, e * e, e * q, q * q, e * v, q * v)
        keep = 1.0 - 1.0 / self._assumed.memory_blocks
        self._sums = [keep * old + weight * new for old, new in zip(self._sums, terms, strict=True)]
        self._count = keep * self._count + 1.0
        phase = self._phase() if self._count > self._assumed.fewest_blocks else 0.0
        self._evident = self._evident + 1 if phase else 0
        self.suspected_rad = phase if self._evident >= self._assumed.suspect_blocks else 0.0
        self.lag_rad = phase if self._evident >= self._assumed.lasting_blocks else 0.0

    def _phase(self) -> float:
        """phi where it is significant, else 0. Normal equations of Eq. 61, the offset eliminated."""
        w, e, q, v, ee, eq, qq, ev, qv = self._sums
        ee, eq, qq = ee - e * e / w, eq - e * q / w, qq - q * q / w
        ev, qv = ev - e * v / w, qv - q * v / w
        determinant = ee * qq - eq * eq
        if determinant <= self._assumed.singular * ee * qq:
            return 0.0
        in_phase, across = (qq * ev - eq * qv) / determinant, (ee * qv - eq * ev) / determinant
        self._offset_stds = abs(v - in_phase * e - across * q) / sqrt(w)
        ratio = hypot(in_phase, across)
        if not self._assumed.least_ratio < ratio < self._assumed.largest_ratio:
            return 0.0
        phase, std = atan2(across, in_phase), sqrt(max(ee, qq) / determinant) / ratio
        if (
            not max(self._assumed.least_rad, self._assumed.phase_stds * std)
            < abs(phase)
            < self._assumed.largest_rad
        ):
            return 0.0
        return phase

    @property
    def shows_offset(self) -> bool:
        """Whether the accelerometer has an offset, independent of the phase and size that it shows of the vibration."""
        return self._offset_stds > self._assumed.offset_stds
