"""An image outside the gate of all filters: a wrong image, a miscounted frame, an impact, a force, or a changed arm.

Implements Eqs. 32, 46 of docs/fused.md.
"""

from collections import deque
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.controller.estimation.fused.accelerometer.blocks import Jump
from stillarm.controller.estimation.fused.accelerometer.impact_detector import ImpactReport
from stillarm.controller.estimation.fused.filters.image_update import (
    ImageInnovation,
    ObservedImage,
    compare_image_at,
)
from stillarm.controller.estimation.fused.filters.jumps import inflate, loosen
from stillarm.controller.estimation.fused.filters.laws import DISTURBED, QUIET, Law
from stillarm.controller.estimation.fused.filters.new_beginning import forget_phase
from stillarm.controller.estimation.fused.fusion.force_onset import begin_force
from stillarm.controller.estimation.fused.fusion.image_delay import ImageDelay
from stillarm.controller.estimation.fused.fusion.state import FusionState

Array = NDArray[np.float64]


class UnexplainedImage:
    """impact: whether the image compared last counts as the first one after an impact."""

    def __init__(self, state: FusionState, delay: ImageDelay) -> None:
        """None seen. delay: how late images come in the mean."""
        self._state, self._delay = state, delay
        self._assumed = state.assumed.outlier
        self._votes = self._voted = 0
        self._late = self._breaks = 0.0
        self._before: deque[tuple[float, Array, Array]] = deque(maxlen=self._assumed.before_frames)
        self.impact = False

    def begin_image(self) -> None:
        """Another image is compared."""
        self._breaks *= 1.0 - 1.0 / self._assumed.break_memory_frames
        self.impact = False

    def outside_gate(self, nis: Array) -> bool:
        """Whether an image is outside the gate of all filters that count."""
        state = self._state
        return bool(
            nis[state.evidence.best] > self._assumed.outlier_nis
            and float(nis[state.evidence.weights > self._assumed.counts].min())
            > self._assumed.outlier_nis_all
        )

    def end_run(self) -> None:
        """The run of images outside their gate, if there was one, is over."""
        self._state.outliers = self._votes = 0

    def remember(self, received_s: float) -> None:
        """Keep what is known, for an impact that is noticed later; only without an accelerometer."""
        bank = self._state.bank
        self._before.append((received_s, bank.x.copy(), bank.p.copy()))

    def forget_before(self) -> None:
        """Forget what was known before: the accelerometer is lost, and the present knowledge is as good."""
        self._before.clear()

    def explain(
        self,
        image: ObservedImage,
        times: Array,
        received_s: float,
        innovation: ImageInnovation,
        report: ImpactReport,
    ) -> bool:
        """Adapt the filters to what explains the image, exposed at times (filters,); whether to use the image."""
        state = self._state
        state.outliers += 1
        if not self._worth_explaining(image, times, received_s, report):
            return False
        if (
            self._votes >= self._assumed.votes
            and self._late / (self._voted * self._votes) > self._assumed.vote_frames * state.frame_s
        ):
            state.dates.recount(self._voted)
            return True
        self._take_for_impact(times, received_s, innovation, report)
        return True

    def _worth_explaining(
        self, image: ObservedImage, times: Array, received_s: float, report: ImpactReport
    ) -> bool:
        """Whether there is more to explain than one wrong image; counts what the arrivals say of a miscounted frame."""
        state = self._state
        if state.held_force.active:
            return state.outliers >= 2
        if report.suspicion < self._assumed.suspicious:
            extra = self._other_count(image, times, received_s)
            if extra != self._voted:
                self._votes, self._late = 0, 0.0
            self._votes += int(extra != 0)
            self._voted = extra
            self._late += received_s - float(times[Law.CLOCK]) - self._delay.mean_s
            return self._votes >= self._assumed.votes or state.outliers > self._assumed.votes
        return report.suspicion >= self._assumed.evident or state.outliers >= 2

    def _take_for_impact(
        self, times: Array, received_s: float, innovation: ImageInnovation, report: ImpactReport
    ) -> None:
        state = self._state
        bank, best = state.bank, state.evidence.best
        self.impact = True
        self._breaks += 1.0
        size = self._assumed.size * abs(float(innovation.residual[best]))
        unseen = report.sees and report.suspicion < self._assumed.suspicious
        # An arm that has changed breaks again and again, and makes the accelerometer contradict, too.
        if (report.in_use and self._breaks > self._assumed.impacts) or unseen:
            # No impact explains it: a force has begun, or the arm or the scene has changed. The quiet filters take it
            # for the former, the disturbed ones for the latter, and the images decide.
            loosen(bank, DISTURBED)
            state.scale_watch.restart()
            state.unless_forced = state.unless_forced or state.as_calibrated
            state.as_calibrated = False
        if state.blind and self._before:
            then_s, x, p = self._before[0]
            grown = state.state_noise * (received_s - then_s)
            grown[:, state.at.shift] += state.dates.shift_noise * (received_s - then_s)
            forget_phase(bank, max(size, self._assumed.size * state.amplitude_m), x, p, grown)
            self._before.clear()
            return
        sizes = (size,) + (self._assumed.higher_mode * size,) * (state.at.modes - 1)
        force_m = size if begin_force(state, float(times[best]), size) else 0.0
        inflate(bank, Jump.guessed(float(times[best]), sizes, force_m, state.assumed.blocks), QUIET)

    @property
    def clock_known(self) -> bool:
        """Whether the clock's law is possible, and its shift known to a part of a frame."""
        state = self._state
        clock = state.evidence.likeliest(Law.CLOCK)
        variance = float(state.bank.p[clock, state.at.shift, state.at.shift])
        return (
            sqrt(variance) <= state.frame_s / self._assumed.clock_known
            and state.evidence.law(Law.CLOCK) >= self._assumed.clock_possible
        )

    def _other_count(self, image: ObservedImage, times: Array, received_s: float) -> int:
        """Number of frames by which the counter is off, if image and arrival agree on it; 0 if they do not.

        A counter of arrivals shows neither lost frames nor a buffer that has begun to hand over older ones.
        """
        if not self.clock_known:
            return 0
        state = self._state
        clock, behind = state.evidence.likeliest(Law.CLOCK), state.dates.dating.behind
        costs: list[tuple[float, int]] = []
        for extra in sorted({-2, -1, 1, 2, 3, behind - 1, behind, behind + 1} - {0}):
            moved = times.copy()
            moved[clock] += extra * state.frame_s
            nis = float(compare_image_at(state.bank, image, moved).nis[clock])
            late = received_s - float(moved[clock]) - self._delay.mean_s
            costs.append((nis + late * late / self._delay.variance, extra))
        cost, extra = min(costs)
        return extra if cost < self._assumed.outlier_nis else 0
