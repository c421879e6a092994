"""Finds out when the filters have been led astray, and from what to start them again.

Implements Eq. 64 of docs/fused.md.

A pull, a push, or images in disorder are not in the filters' model, and move them. Two other explanations are held
ready for the images of the last period: a free vibration, or one about a constant force, with all else as the filters
have it now (fresh_fit.py), and a free one with all else as it was when all was well (remembered.py). One is taken where
images cost clearly less by it than they have cost the filters; what was known before, where they cost hardly more.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stillarm.controller.estimation.fused.arm.joint_input import JointInput
from stillarm.controller.estimation.fused.arm.layout import Layout
from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions
from stillarm.controller.estimation.fused.dates.evidence import Evidence
from stillarm.controller.estimation.fused.dates.frame_dates import FrameDates
from stillarm.controller.estimation.fused.filters.bank import FilterBank
from stillarm.controller.estimation.fused.filters.laws import LAWS
from stillarm.controller.estimation.fused.filters.new_beginning import restore
from stillarm.controller.estimation.fused.recovery.fresh_fit import Fresh, HeldImages, fresh_fit
from stillarm.controller.estimation.fused.recovery.remembered import Remembered

Array = NDArray[np.float64]


class Situation(NamedTuple):
    """After an image. nis: its normalised innovation squared by the most likely filter; broke: whether it, or the
    one before, left its gate; held, moves: whether a force is held, and changes; shaken: whether a steady random force
    is known; calm: whether all is well, and the image's zero known; elsewhere: whether something else is found to be
    wrong, the dates or the scale. joint: what it did, None before the first image."""

    time_s: float
    nis: float
    broke: bool
    held: bool
    moves: bool
    shaken: bool
    calm: bool
    elsewhere: bool
    amplitude_m: float
    joint: JointInput | None


class FreshStart:
    """Watches for filters led astray; `choose` gives a fit that they are to be started from."""

    def __init__(
        self, at: Layout, image_m2: float, state_noise: Array, shift_spread_s: float, bank: FilterBank,
        dates: FrameDates, evidence: Evidence, assumed: Assumptions = ASSUMPTIONS,
    ) -> None:  # fmt: skip
        """image_m2: variance of an image's noise, m^2; state_noise: growth of the states' variances, (filters, n), 1/s;
        shift_spread_s: how far a delay wanders, s. bank, dates, evidence: the filters that are watched."""
        self._assumed = assumed.fresh_start
        self._at, self._image_m2 = at, image_m2
        self._state_noise, self._shift_variance = state_noise, shift_spread_s**2
        self._bank, self._dates, self._evidence = bank, dates, evidence
        self._slow_states = [*range(2 * at.modes, 4 * at.modes)]
        self._images = HeldImages(assumed)
        self.remembered = Remembered(assumed)
        self._recent = 1.0
        self._astray_until_s, self._not_before_s = float("-inf"), float("-inf")
        self._changes = 0

    def add(self, nominal_s: Array, value_m: float, noise_m2: float, nis: float, variance: float) -> None:
        """An image: its nominal instant by each law, s, (laws,), what it shows, m, its variance, m^2, and the filters'
        innovation squared over its variance, and that, m^2."""
        cost = min(nis, self._assumed.largest_nis) + float(np.log(max(variance, noise_m2) / noise_m2))
        self._images.add(nominal_s, value_m, noise_m2, cost)

    def forget(self) -> None:
        """Dates, or the image's zero, have changed."""
        self._images.forget()
        self.remembered.forget()

    def astray(self, time_s: float) -> bool:
        """Whether the filters may have been led astray lately."""
        return time_s < self._astray_until_s

    def choose(self, now: Situation) -> Fresh | None:
        """A fit to start from, or None. If the fit uses what was known before, the bank is set to that already."""
        assumed = self._assumed
        if self._dates.changes != self._changes:
            self._changes = self._dates.changes
            self.forget()
        self._recent += (min(now.nis, assumed.largest_nis) - self._recent) / assumed.recent_images
        inconsistent = self._recent > assumed.inconsistent
        self._watch(now, inconsistent)
        blocked = now.time_s < self._not_before_s or now.elsewhere or (now.shaken and not now.held)
        if now.joint is None or blocked or not self.astray(now.time_s):
            return None
        found, periods = self._first_good(now, now.joint, inconsistent)
        if found is not None:
            self._recent = 1.0
            self._not_before_s = now.time_s + periods * self._at.period_s
        return found

    def _watch(self, now: Situation, inconsistent: bool) -> None:
        bank, evidence = self._bank, self._evidence
        if now.held or inconsistent or now.broke:
            self._astray_until_s = now.time_s + self._assumed.astray_periods * self._at.period_s
            self.remembered.trouble()
        elif now.calm and not self.astray(now.time_s) and evidence.best < LAWS:
            self.remembered.calm(now.time_s, bank.x, bank.p, evidence.log_weights)

    def _first_good(
        self, now: Situation, joint: JointInput, inconsistent: bool
    ) -> tuple[Fresh | None, float]:
        """The first fit that explains the images, and over how many periods of them."""
        assumed = self._assumed
        differs = self.remembered.differs(self._bank.x[self._evidence.best], self._slow_states)
        cheaper = assumed.cheaper_shaken if now.shaken else assumed.cheaper
        for periods in assumed.periods:
            whole = periods >= assumed.forced_periods
            if whole and (differs or now.held):
                known = self._as_remembered(now, joint, periods)
                if known is not None:
                    return known, periods
            for force, asked in ((False, now.held or inconsistent), (True, whole and now.held)):
                if not asked or (force and not (inconsistent or now.moves)):
                    continue
                fresh = self._fit(now, joint, periods, force=force)
                if fresh is not None and self._good(fresh, cheaper):
                    return fresh, periods
        return None, 0.0

    def _as_remembered(self, now: Situation, joint: JointInput, periods: float) -> Fresh | None:
        """If what was known when all was well explains the last images, nothing of it has changed."""
        bank, known = self._bank, self.remembered.known
        if known is None:
            return None
        before = bank.x.copy(), bank.p.copy()
        since_s = now.time_s - known.time_s
        grown = self._state_noise * since_s
        grown[:, self._at.shift] += np.minimum(self._dates.shift_noise * since_s, self._shift_variance)
        restore(bank, known.x, known.p, grown)
        free = self._fit(now, joint, periods, force=False, learn=True)
        if free is not None and self._good(free, self._assumed.no_dearer):
            self._evidence.restore(known.log_weights)
            return free
        bank.x, bank.p = before
        self._not_before_s = now.time_s + self._assumed.again_periods * self._at.period_s
        return None

    def _fit(
        self, now: Situation, joint: JointInput, periods: float, *, force: bool, learn: bool = False
    ) -> Fresh | None:
        """Fit the images of the last periods, as the filters date them; None for too few images."""
        span_s = periods * self._at.period_s
        window = self._images.newest(span_s, self._evidence.best % LAWS, now.time_s)
        if window is None:
            return None
        return fresh_fit(window, self._bank, self._at, joint, now.amplitude_m, force=force, learn=learn)

    def _good(self, fresh: Fresh, least_gain: float) -> bool:
        """Whether it explains the images, at so much less than they have cost the filters, and tells the vibration."""
        best, assumed = self._evidence.best, self._assumed
        most = assumed.good_misfit + assumed.misfit_stds * sqrt(2.0 / fresh.freedom)
        if fresh.gain[best] < least_gain or fresh.misfit[best] > most:
            return False
        phasor = slice(0, 2 * self._at.modes)
        power = float(fresh.mean[best, phasor] @ fresh.mean[best, phasor])
        known = max(assumed.good_share**2 * power, self._image_m2)
        return float(np.trace(fresh.covariance[best, phasor, phasor])) < known
