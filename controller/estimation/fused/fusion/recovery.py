"""Restarts after an image: when the filters are lost, their dates are wrong, or the vibration was misled.

Implements Eqs. 60, 61, 62, 64, 66 of docs/fused.md.
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.controller.estimation.fused.filters.date_update import doubt_dates, redate
from stillarm.controller.estimation.fused.filters.jumps import end_force, forget_zero
from stillarm.controller.estimation.fused.filters.laws import CLOCKED, FILTERS, LAWS
from stillarm.controller.estimation.fused.filters.new_beginning import begin_near, start_vibration
from stillarm.controller.estimation.fused.fusion.state import FusionState
from stillarm.controller.estimation.fused.fusion.unexplained_image import UnexplainedImage
from stillarm.controller.estimation.fused.recovery.fresh_fit import Fresh
from stillarm.controller.estimation.fused.recovery.fresh_start import Situation

Array = NDArray[np.float64]


class Recovery:
    """dates_doubted: whether the vibration was started anew lately, for an unknown reason."""

    def __init__(self, state: FusionState, unexplained: UnexplainedImage) -> None:
        """All is well."""
        self._state, self._unexplained = state, unexplained
        self._received_s = 0.0
        self._dates_doubted_until_s = float("-inf")
        self._begun_s = float("inf")  # when the filters began without anything known
        self._begins = 0
        self._agreed = False  # whether the accelerometer has ever shown what the images say

    @property
    def dates_doubted(self) -> bool:
        return self._received_s < self._dates_doubted_until_s

    def recover(self, received_s: float) -> bool:
        """After an image read at received_s; whether the filters have begun anew."""
        return self._check(received_s) or self._start_fresh(received_s)

    def forget_wrong_dates(self) -> None:
        """Forget what was learnt about the accelerometer by a wrong clock."""
        state = self._state
        state.health.begin_comparison()
        state.date_watch.restart()
        state.fresh.forget()
        state.scale_watch.restart()
        state.images = 0
        self._unexplained.end_run()
        state.as_calibrated, state.unless_forced = True, False
        if state.held_force.active:
            end_force(state.bank)
            state.held_force.end(state.bank.edge_s)
        state.slow_pull.restart()

    def forget_zero(self) -> None:
        """Forget the image zero: the following images have another, which contains a held force."""
        state = self._state
        if state.held_force.active:
            end_force(state.bank)
            state.held_force.end(state.bank.edge_s, explained=True)
        forget_zero(state.bank)
        state.images = 0
        self._unexplained.end_run()
        state.slow_pull.restart()
        state.fresh.forget()

    def _check(self, received_s: float) -> bool:
        state = self._state
        bank, at, best, consistency = state.bank, state.at, state.evidence.best, state.consistency
        clocked = CLOCKED[best] and not state.dates.period_found
        skew = float(bank.x[best, at.skew]) if clocked else 0.0
        skew_std = sqrt(max(float(bank.p[best, at.skew, at.skew]), 0.0))
        lost = consistency.see(received_s, state.nis, skew, skew_std, state.delay_s)
        if self._never_agrees(received_s):
            self._begins += 1
            self._begun_s = received_s
            self._begin_anew(received_s)
            return True
        lag_rad = state.date_watch.lag_rad
        if lag_rad and not state.shaken:
            redate(bank, -lag_rad / at.w_first)
            self.forget_wrong_dates()
            state.images = max(state.images, 1)
            consistency.begin(received_s)
            return True
        if (
            lost
            and state.fresh.remembered.known is not None
            and not consistency.lost_for(received_s, self._state.assumed.consistency.known_patience_s)
        ):
            return False  # what was known may still explain the images
        if not lost or state.shaken or state.held_force.active:  # what shakes the arm is no wrong date
            return False
        phasors = bank.x[best].copy()
        self._begin_anew(received_s)
        begin_near(bank, phasors)
        state.images = 1  # the image's zero is known
        return True

    def _never_agrees(self, received_s: float) -> bool:
        """Whether the accelerometer has contradicted the images from the beginning: then the beginning was wrong. A
        sensor that still does after some beginnings has another gain; and a force larger than wrong dates make of the
        vibration shows in the images alone."""
        state, assumed = self._state, self._state.assumed.consistency
        self._begun_s = min(self._begun_s, received_s)
        self._agreed = self._agreed or (state.health.agrees and state.consistency.proven)
        since_s = received_s - self._begun_s
        return (
            not self._agreed
            and state.health.mute
            and since_s > assumed.patience_s
            and self._begins < assumed.most_beginnings
            and not self._holds_more_than_wrong_dates()
        )

    def _holds_more_than_wrong_dates(self) -> bool:
        state = self._state
        force_m = abs(float(state.bank.x[state.evidence.best, state.at.force]))
        held = state.held_force
        return held.active and force_m > held.by_wrong_dates_m(state.amplitude_m)

    def _begin_anew(self, received_s: float) -> None:
        self._state.dates.begin_anew(received_s)
        self.forget_wrong_dates()
        self._state.consistency.begin(received_s)

    def _start_fresh(self, received_s: float) -> bool:
        """Start the vibration anew where the filters were led astray, if the last images tell from what."""
        state = self._state
        held = state.held_force
        now = Situation(
            received_s, state.nis, self._unexplained.impact or state.outliers > 0, held.active, held.moves,
            state.shaken, state.consistency.calm and self._zero_known,
            state.date_watch.suspected_rad != 0.0 or state.scale_watch.drifts, state.amplitude_m,
            state.joint_input,
        )  # fmt: skip
        fresh = state.fresh.choose(now)
        self._received_s = received_s
        if fresh is not None:
            self._begin_with(fresh, received_s)
        return fresh is not None

    @property
    def _zero_known(self) -> bool:
        """Whether the image's zero is known far better than one image tells it."""
        state = self._state
        variance = state.bank.zero_variance(state.evidence.best, state.held_m)
        return variance < state.assumed.fresh_start.zero_learnt * state.image_m2

    def _misdated(self, now_s: float, *, forced: bool) -> Array:
        """Variance of what moved the dates while the filters were led astray (Eq. 66), s^2, (filters,). forced: whether
        a force has led them astray."""
        state = self._state
        assumed = state.assumed.fresh_start
        most = np.full(FILTERS, (assumed.dates_doubt_frames * state.frame_s) ** 2)
        known = state.fresh.remembered.known
        if known is None:
            return most
        t, k = state.at.shift, state.at.skew
        departed = state.bank.x[:, t] - known.x[:, t] - known.x[:, k] * (now_s - known.time_s)
        unknown = 0.0 if forced else (assumed.clock_doubt_frames * state.frame_s) ** 2
        return np.where(CLOCKED, np.minimum(most, departed * departed + unknown), most)

    def _begin_with(self, fresh: Fresh, now_s: float) -> None:
        state = self._state
        bank, held, m, best = state.bank, state.held_force, state.at.modes, state.evidence.best
        forced = held.active
        start_vibration(bank, fresh.states, fresh.mean, fresh.covariance, fresh.parts)
        if fresh.parts > 2 * m:
            held.rests(float(fresh.mean[best, 2 * m]), now_s)
        elif held.active:
            held.end(now_s, explained=True)
        state.health.begin_comparison()
        if forced and state.unless_forced and best < LAWS:  # a force, and no other arm or scene
            state.as_calibrated, state.unless_forced = True, False
        if forced:  # what a force did looked like a phase, another scale, or a random force
            state.date_watch.restart()
            state.scale_watch.begin()
            if fresh.misfit[best] < self._state.assumed.fresh_start.no_random_force:
                state.force.restart()
        if not state.blind:  # the dates may have been wrong: images cannot tell, the accelerometer will
            doubt_dates(bank, self._misdated(now_s, forced=forced))
        self._dates_doubted_until_s = now_s + state.at.period_s
        state.slow_pull.restart()
        self._unexplained.end_run()
