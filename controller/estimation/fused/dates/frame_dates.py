"""When frames were exposed: by their count, stamps, arrivals and n_i, each law with what it tells the filters.

Implements Eqs. 21, 22, 23, 25 of docs/fused.md.
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.model import Model
from stillarm.controller.estimation.fused.arm.layout import Layout
from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions
from stillarm.controller.estimation.fused.dates.arrival_floor import ArrivalFloor
from stillarm.controller.estimation.fused.dates.arrivals import ArrivalSpread
from stillarm.controller.estimation.fused.dates.clock_rate import ClockRate
from stillarm.controller.estimation.fused.dates.dating import Dating
from stillarm.controller.estimation.fused.dates.evidence import Evidence
from stillarm.controller.estimation.fused.dates.joint_date import JointDate
from stillarm.controller.estimation.fused.filters import start
from stillarm.controller.estimation.fused.filters.bank import FilterBank
from stillarm.controller.estimation.fused.filters.date_update import (
    advance_dating,
    begin_late,
    doubt_lateness,
    forget_started,
    place,
    update_by_arrival,
    update_by_started,
)
from stillarm.controller.estimation.fused.filters.laws import FILTERS, LAW_OF, LAWS, Law
from stillarm.controller.estimation.fused.learning.learnt_walks import LearntWalk, LearntWander

Array = NDArray[np.float64]


class FrameDates:
    """Dates each frame: `accept`, then `update_by_arrival` and `update_by_started`, which may wait for later cycles.

    lead_walk: of n_i's lead by the law DRIFT, as assumed, s^2/s. shift_noise: growth of the variance of each filter's
    shift, s^2/s, (filters,). period_found: whether the frames' period was found to be another than the stated one; it
    is known to some parts in a thousand then. changes: number of changes of the count's origin or of a law's clock.
    """

    def __init__(
        self,
        model: Model,
        at: Layout,
        bank: FilterBank,
        evidence: Evidence,
        lead: LearntWalk,
        assumed: Assumptions = ASSUMPTIONS,
    ) -> None:
        """bank, evidence: told what dates say; lead: how far n_i's lead has been seen to walk."""
        self._assumed, self._start = assumed.dates, assumed.start
        self._at = at
        self._bank, self._evidence = bank, evidence
        self._lead = lead
        self._frame_s, self._cycle_s = start.frame_s(model), model.timing.cycle_s
        self._model_delay_s = model.timing.capture_delay_s
        self._first_shift_s = start.first_shift_s(model, assumed)
        self._spread_s = spread_s = start.spread_s(model, assumed)
        self.dating = Dating(self._frame_s, self._model_delay_s, spread_s, assumed)
        self.shift_noise, self._shift_return = start.shift_noise(model, assumed), start.shift_return(assumed)
        self._wanders = [
            LearntWander(at, law, self.shift_noise, self._shift_return, assumed)
            for law in (Law.DRIFT, Law.STEADY)
        ]
        self._joint_date = JointDate(assumed)
        self._floors = [ArrivalFloor(spread_s, assumed) for _ in range(2)]
        self._waited = [True] * FILTERS  # whether the filter's shift has followed arrivals until now
        self._clock_rate = ClockRate(spread_s, self._cycle_s, assumed)
        self._spread = [ArrivalSpread(self._frame_s, spread_s, self._cycle_s, assumed) for _ in range(2)]
        self._started = [
            ArrivalSpread(self._frame_s, self._frame_s, self._cycle_s, assumed) for _ in range(2)
        ]
        self._between = ArrivalSpread(self._frame_s, self._frame_s, self._cycle_s, assumed)
        self._strange = 0
        self.lead_walk = 0.0
        self.changes = 0
        self.period_found = False
        self._arrived: tuple[VisualSample, float] | None = None
        self._begun: Array | None = None  # n_i plus a frame less each law's nominal instant, (laws,), s

    @property
    def instants_s(self) -> Array:
        """Nominal instant of the frame accepted last by each filter's law, s, (filters,)."""
        result: Array = self.dating.nominal[LAW_OF]
        return result

    def expected_instant_s(self) -> float:
        """When the frame accepted last was exposed, by the most likely filter."""
        best = self._evidence.best
        return float(self.dating.nominal[best % LAWS] + self._bank.x[best, self._at.shift])

    def learn_wander(self, law: int) -> None:
        """After an image: how fast the delay wanders; law: that is believed."""
        for wander in self._wanders:
            wander.see(self._bank, law)

    def recount(self, frames: int) -> None:
        """The count was that many frames short."""
        self.dating.nominal[Law.CLOCK] += frames * self._frame_s
        self._restart_watch(Law.CLOCK)

    def accept(self, sample: VisualSample, received_s: float, *, images_tell: bool) -> bool:
        """Date a frame, the one before being done with; False for one not to be used. images_tell: Dating.accept."""
        first = not self.dating.started
        if not self.dating.accept(sample, received_s, images_tell=images_tell):
            return False
        if first:
            return True
        dating, t, bank = self.dating, self._at.shift, self._bank
        elapsed = dating.elapsed[LAW_OF]
        advance_dating(bank, elapsed, self._shift_return, self.shift_noise, self._assumed.skew_walk)
        for law, doubt in ((Law.CLOCK, dating.doubt_s), (Law.STAMPS, dating.stamp_doubt_s)):
            if doubt:
                bank.p[law::LAWS, t, t] += doubt**2
                self._restart_watch(law)
        if dating.stamped and not self._evidence.stamps_admitted:
            self._evidence.admit_stamps(bank, dating)
            self.changes += 1
            self._spread[Law.STAMPS].restart()
            self._started[Law.STAMPS].restart()
        self._arrived = sample, received_s
        return True

    def update_by_arrival(self) -> bool:
        """Measurement update by the arrival of the frame accepted last, unless made. Returns whether it has refuted the
        believed clock, so that everything learnt by it was reset."""
        if self._arrived is None:
            return False
        (sample, received_s), self._arrived = self._arrived, None
        nominal, elapsed = self.dating.nominal, self.dating.elapsed
        anew = self._watch_clock(received_s)
        late = received_s - self._model_delay_s - nominal
        noise, walk = np.full(LAWS, self._assumed.no_arrival_s2), np.zeros(LAWS)
        for law in (Law.CLOCK, Law.STAMPS):
            spread, floor = self._spread[law], self._floors[law]
            if not floor.see(float(late[law])):
                continue
            if floor.fell:
                spread.restart()
            spread.add(float(late[law]))
            if not self._place(law, floor):
                noise[law], walk[law] = spread.white, spread.walk * elapsed[law]
        started = sample.started_cycle * self._cycle_s + self._frame_s - nominal
        self.dating.nominal[Law.JITTER] += self._joint_correction_s(sample, received_s)
        update_by_arrival(self._bank, late[LAW_OF], noise[LAW_OF], walk[LAW_OF])
        self._begun = started
        return anew

    def update_by_started(self) -> None:
        """Measurement update by n_i after that by the arrival, unless made. n_i counts once its wander is known."""
        if self._begun is None:
            return
        started, self._begun = self._begun, None
        elapsed, between = self.dating.elapsed, self._between
        noise, walk = np.full(LAWS, self._assumed.no_arrival_s2), np.zeros(LAWS)
        for law in (Law.CLOCK, Law.STAMPS):
            spread = self._started[law]
            spread.add(float(started[law]))
            if spread.known:
                noise[law], walk[law] = spread.white, spread.walk * elapsed[law]
        between.add(float(started[Law.STEADY]))
        if not between.known:
            return
        noise[Law.STEADY] = noise[Law.DRIFT] = between.white
        own = 0.5 * (between.walk + self._started[Law.CLOCK].walk - self._spread[Law.CLOCK].walk)
        walk[Law.STEADY] = between.walk * elapsed[Law.STEADY]
        self.lead_walk = max(own, self._assumed.of_started * between.walk)
        walk[Law.DRIFT] = self._lead.share * self.lead_walk * elapsed[Law.DRIFT]
        self._strange = self._strange + 1 if self._is_strange(started, noise) else 0
        if self._strange == 0:
            update_by_started(self._bank, started[LAW_OF], noise[LAW_OF], walk[LAW_OF])
        elif self._strange > self._assumed.strange_frames:
            self._forget_started()

    def _forget_started(self) -> None:
        self._strange = 0
        forget_started(self._bank, (self._start.ahead_frames * self._frame_s) ** 2)
        self._lead.forget()
        for spread in (*self._started, self._between):
            spread.restart()

    def _restart_watch(self, law: Law) -> None:
        """Restart what arrivals and n_i teach: those before and after a change of the count or the period cannot be
        compared."""
        self.changes += 1
        self._spread[law].restart()
        self._started[law].restart()
        self._floors[law].restart()
        if law is Law.CLOCK:
            self._joint_date.restart()
            self._clock_rate.restart()

    def _watch_clock(self, received_s: float) -> bool:
        """Correct the clock's period if arrivals run away from it and images have not confirmed it; whether that clock
        was believed."""
        dating, bank, at = self.dating, self._bank, self._at
        instant = float(dating.nominal[Law.CLOCK])
        rate = self._clock_rate.add(instant, received_s - instant)
        if rate is None:
            return False
        skew = float(bank.p[self._evidence.likeliest(Law.CLOCK), at.skew, at.skew])
        believed = self._evidence.law(Law.CLOCK) > 0.5
        if believed and skew < self._assumed.confirmed * self._start.skew**2:
            return False
        dating.change_period(1.0 + rate.rate)
        self.period_found = True
        if believed:
            self.begin_anew(received_s)
        else:
            self._evidence.begin_clock(bank, dating)
        for target in range(int(Law.CLOCK), FILTERS, LAWS):
            bank.p[target, at.skew, at.skew] = rate.std**2
        self._restart_watch(Law.CLOCK)
        return believed

    def follow_started(self, *, early: bool) -> None:
        """early: whether n_i counts as soon as it can, since nothing else dates the images."""
        for spread in (*self._started, self._between):
            spread.early = early

    def arrive_anew(self) -> None:
        """Another supervisor sends the images: they may take longer, or less long, than its predecessor's, and its n_i
        may lie elsewhere."""
        for law in (Law.CLOCK, Law.STAMPS):
            self._restart_watch(law)
        self._forget_started()
        doubt_lateness(self._bank, self._first_shift_s**2, self._spread_s**2)

    def begin_anew(self, received_s: float) -> None:
        """Forget all that was learnt by wrong dates."""
        self.changes += 1
        self._bank.begin()
        self.dating.nominal[:] = received_s - self._model_delay_s
        self._evidence.begin()
        self._waited = [True] * FILTERS
        for law in (Law.CLOCK, Law.STAMPS):
            self._restart_watch(law)

    def _place(self, law: Law, floor: ArrivalFloor) -> bool:
        """Whether images have yet to tell the law's shift: until then it follows the arrivals near their floor.

        Earlier knowledge of the clock from its arrivals is forgotten then, as after a queue has drained. The arrivals
        then tell only how the mean delay, which is unknown again, wanders.
        """
        bank, t = self._bank, self._at.shift
        waits = False
        for target in range(int(law), FILTERS, LAWS):
            if float(bank.p[target, t, t]) > self._assumed.waits_until * bank.first_variance(target, t):
                place(bank, target, floor.mean_s)
                waits = True
            elif floor.fell or self._waited[target]:
                begin_late(bank, target, floor.mean_s)
            self._waited[target] = waits
        return waits

    def _is_strange(self, started: Array, noise: Array) -> bool:
        """Whether n_i has jumped, by the most likely filter."""
        best, at = self._evidence.best, self._at
        x, p, law = self._bank.x[best], self._bank.p[best], best % LAWS
        variance = p[at.shift, at.shift] + p[at.ahead, at.ahead] - 2.0 * p[at.shift, at.ahead] + noise[law]
        off = started[law] - x[at.shift] + x[at.ahead]
        return bool(off * off > self._assumed.strange_nis * variance)

    def _joint_correction_s(self, sample: VisualSample, received_s: float) -> float:
        """What n_i and the frame's number add to the arrival, s."""
        spread = self._spread[Law.CLOCK]
        gain = min(
            max(sqrt(0.5 * spread.walk * self._frame_s / spread.white), self._assumed.number_gain_least),
            self._assumed.number_gain_most,
        )
        started_s = sample.started_cycle * self._cycle_s - received_s
        return self._joint_date.correction_s(
            started_s, float(self.dating.nominal[Law.CLOCK]) - received_s, gain
        )
