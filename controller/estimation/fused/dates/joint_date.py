"""One date from three: a frame's arrival, its n_i and its number, if each errs from frame to frame.

Implements Eqs. 27, 28 of docs/fused.md.

The error of each follows from the differences of the three: with the variances V_ab of their differences, v_a = (V_ab +
V_ac - V_bc) / 2 (the three-cornered hat: J. E. Gray and D. W. Allan, Proc. 28th Frequency Control Symposium, 1974). The
differences' means are tracked: an offset is nobody's error, a number's offset wanders.
"""

from math import sqrt

from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions


class JointDate:
    """Adds to the arrival what n_i and the frame's number say of this frame."""

    def __init__(self, assumed: Assumptions = ASSUMPTIONS) -> None:
        """Nothing seen."""
        self._assumed = assumed.dates
        self.restart()

    def restart(self) -> None:
        """Differences across what has happened mean nothing."""
        self._frames = 0
        self._means = (0.0, 0.0)
        self._last = (0.0, 0.0)
        self._squares = [
            0.0,
            0.0,
            0.0,
        ]  # of the steps of: started - arrival, number - arrival, started - number

    def correction_s(self, started_s: float, numbered_s: float, number_gain: float) -> float:
        """What is to be added to the arrival, s. Both arguments: less the arrival.

        number_gain: how much of a difference the number's offset follows in a frame, 0 to 1.
        """
        now = (started_s, numbered_s)
        if self._frames == 0:
            self._frames, self._means, self._last = 1, now, now
            return 0.0
        self._frames += 1
        share = 1.0 / min(float(self._frames), self._assumed.joint_frames)
        step = (now[0] - self._last[0], now[1] - self._last[1])
        self._last = now
        for i, one in enumerate((step[0], step[1], step[0] - step[1])):
            self._squares[i] += (0.5 * one * one - self._squares[i]) * share
        off = (now[0] - self._means[0], now[1] - self._means[1])
        gains = (max(share, self._assumed.joint_offset_gain), max(share, number_gain))
        self._means = (self._means[0] + gains[0] * off[0], self._means[1] + gains[1] * off[1])
        return self._weighed(off) if self._frames > self._assumed.joint_begin_frames else 0.0

    def _weighed(self, off: tuple[float, float]) -> float:
        started, numbered, between = self._squares
        if any(
            abs(one) > self._assumed.joint_outside_stds * sqrt(2.0 * square)
            for one, square in zip(off, self._squares, strict=False)
        ):
            return 0.0  # one of them follows something else: the three say nothing of each other
        least = self._assumed.joint_least_s * self._assumed.joint_least_s
        own = 1.0 / max(0.5 * (started + numbered - between), least)
        total, result = own, 0.0
        for one, variance in (
            (off[0], 0.5 * (started + between - numbered)),
            (off[1], 0.5 * (numbered + between - started)),
        ):
            weight = 1.0 / max(variance, least)
            total += weight
            result += weight * one
        return result / total
