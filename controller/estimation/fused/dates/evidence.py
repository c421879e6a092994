"""Which filter the images support: probabilities with a fading memory, and refuted filters started again.

Implements Eqs. 37, 38, 39 of docs/fused.md.
"""

from math import log

import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.configuration import Fused
from stillarm.common.files.model import Model
from stillarm.controller.estimation.fused.arm.layout import Layout
from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions
from stillarm.controller.estimation.fused.dates.dating import Dating
from stillarm.controller.estimation.fused.filters import start
from stillarm.controller.estimation.fused.filters.bank import FilterBank
from stillarm.controller.estimation.fused.filters.laws import FILTERS, LAWS, LEVELS, Law
from stillarm.controller.estimation.fused.filters.new_beginning import copy_filter, start_anew
from stillarm.controller.estimation.fused.small_arrays import largest, summed

Array = NDArray[np.float64]


class Evidence:
    """Probabilities of the filters, weights (filters,); best: the most probable filter."""

    def __init__(
        self, model: Model, settings: Fused, at: Layout, length_m: float, assumed: Assumptions = ASSUMPTIONS
    ) -> None:
        """As the model's camera mode suggests."""
        self._assumed = assumed.evidence
        self._first_disturbed = assumed.start.disturbed
        self._at = at
        self._delay_s = model.timing.capture_delay_s
        self._first = start.variances(model, settings, at, length_m, assumed)
        self._prior = start.beliefs(model, assumed)
        self.stamps_admitted = False
        self._while_seeing = self._prior
        self.begin()

    def begin(self) -> None:
        """No image has told anything."""
        self._log = np.zeros(FILTERS)
        self._refuted_for = np.zeros(FILTERS)
        self._disturbed = self._first_disturbed
        self._level = np.zeros(FILTERS)
        self._expect_level()
        self._normalise()
        self._usual: Array = self._by_law()

    def _normalise(self) -> None:
        total = self._prior + self._level + self._log
        weights = np.exp(total - largest(total))
        self.weights: Array = weights / summed(weights)
        self.best = int(total.argmax())

    def likeliest(self, law: Law) -> int:
        """The more probable one of a law's filters."""
        return int(law) + LAWS * int(self.weights[law::LAWS].argmax())

    def law(self, law: Law) -> float:
        """Probability of a law, summed over the levels of disturbance."""
        return float(summed(self.weights[law::LAWS]))

    def _by_law(self) -> Array:
        result: Array = summed(self.weights.reshape(LEVELS, LAWS), 0)
        return result

    def weigh(self, nis: Array, variance: Array) -> None:
        """Process an image's normalised innovations squared and their variances, m^2."""
        keep = 1.0 - 1.0 / self._assumed.memory_frames
        self._log = keep * self._log - 0.5 * (np.minimum(nis, self._assumed.largest_nis) + np.log(variance))
        self._log -= largest(self._log)
        np.maximum(self._log, self._assumed.lowest, out=self._log)
        self._normalise()

    def remember(self) -> None:
        """After an image, seen beside an accelerometer: which laws are usual, and how often the arm is disturbed.

        That probability, slowly averaged, is the prior for the next image.
        """
        self._usual += (self._by_law() - self._usual) / self._assumed.usual_frames
        now = float(summed(self.weights[LAWS:]))
        learnt = self._disturbed + (now - self._disturbed) / self._assumed.level_frames
        self._disturbed = min(max(learnt, self._assumed.least_disturbed), self._assumed.most_disturbed)
        self._expect_level()

    def _expect_level(self) -> None:
        self._level[LAWS:] = log(self._disturbed / (1.0 - self._disturbed))

    @property
    def log_weights(self) -> Array:
        """Logarithms of the filters' probabilities by the last images, (filters,)."""
        return self._prior + self._level + self._log

    def restore(self, log_weights: Array) -> None:
        """Set the probabilities back to these, with which the filters were stored."""
        self._log = np.maximum(log_weights - self._prior - self._level, self._assumed.lowest)
        self._log -= largest(self._log)
        self._refuted_for[:] = 0.0
        self._normalise()

    def admit_stamps(self, bank: FilterBank, dating: Dating) -> None:
        """The camera stamps its frames: from now on that law counts, starting from what the best one knows."""
        self.stamps_admitted = True
        best = self.best
        dating.nominal[Law.STAMPS] = dating.nominal[best % LAWS] + bank.x[best, self._at.shift]
        spread = float(self._first[best, self._at.shift])
        for target in range(int(Law.STAMPS), FILTERS, LAWS):
            self._start(bank, target, best, 0.0, spread)
            self._prior[target] = self._prior[target - 1] + self._assumed.stamps_odds
        self._normalise()

    def begin_clock(self, bank: FilterBank, dating: Dating) -> None:
        """The clock's period was another: its law begins anew, from what the best one of the others knows."""
        others = np.where(np.arange(FILTERS) % LAWS == Law.CLOCK, 0.0, self.weights)
        best, at = int(np.argmax(others)), self._at
        instant = float(dating.nominal[best % LAWS] + bank.x[best, at.shift])
        variance = max(
            float(bank.p[best, at.shift, at.shift] + bank.jitter[best]), self._assumed.least_shift_s**2
        )
        for target in range(int(Law.CLOCK), FILTERS, LAWS):
            self._start(bank, target, best, instant - float(dating.nominal[Law.CLOCK]), variance)
            self._log[target] = self._log[best] - self._assumed.unproven
            self._refuted_for[target] = 0.0
        self._normalise()

    def respawn(self, bank: FilterBank, dating: Dating, instant_s: float, std_s: float) -> None:
        """A filter refuted for a while starts again from the best one; instant_s: of the last frame, with std_s."""
        best = self.best
        low = self.weights < self._assumed.refuted
        if not self.stamps_admitted:
            low[Law.STAMPS :: LAWS] = False
        counts = self._refuted_for
        counts += 1.0
        counts *= low
        if largest(counts) <= self._assumed.memory_frames:
            return
        for target in np.flatnonzero(counts > self._assumed.memory_frames).tolist():
            counts[target] = 0.0
            law = Law(target % LAWS)
            of_law = self.likeliest(law)
            if self.weights[of_law] > self._assumed.possible:
                copy_filter(bank, target, of_law)
            else:
                shift = instant_s - float(dating.nominal[law])
                self._start(bank, target, best, shift, max(std_s, self._assumed.least_shift_s) ** 2)
            self._log[target] = -self._assumed.unproven

    def go_blind(self, bank: FilterBank, dating: Dating, instant_s: float, std_s: float) -> None:
        """The accelerometer is lost: images alone can hardly tell a drifting delay from a changed frequency.

        The laws therefore keep the probabilities that they had, and unlikely laws lose their own shift.
        """
        best = self.best
        unlikely = np.tile(self._usual < self._assumed.unlikely, LEVELS)
        if not self.stamps_admitted:
            unlikely[Law.STAMPS :: LAWS] = False
        for target in np.flatnonzero(unlikely).tolist():
            shift = instant_s - float(dating.nominal[target % LAWS])
            self._start(bank, target, best, shift, max(std_s, self._assumed.least_shift_s) ** 2)
        self._while_seeing = self._prior
        laws = np.log(np.maximum(self._usual, self._assumed.least_usual))
        laws[self._usual < self._assumed.unlikely] -= self._assumed.blind_handicap
        self._prior = np.tile(laws, LEVELS)

    def see_again(self) -> None:
        """The accelerometer is back."""
        self._prior = self._while_seeing

    def _start(self, bank: FilterBank, target: int, source: int, shift_s: float, variance: float) -> None:
        at, first = self._at, self._first[target]
        start_anew(bank, target, source, shift_s, (variance, float(first[at.skew]), float(first[at.late])))
