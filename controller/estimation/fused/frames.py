"""Images in their order with the accelerometer's blocks before them, and what follows for the delay."""

from collections import deque
from math import isfinite, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.configuration import Fused
from stillarm.common.files.model import Model
from stillarm.controller.estimation.fused import start
from stillarm.controller.estimation.fused.bank import (
    DISTURBED,
    FILTERS,
    LAW_OF,
    LAWS,
    QUIET,
    AimedAtBlock,
    FilterBank,
    Law,
    Seen,
    Vibration,
)
from stillarm.controller.estimation.fused.blocks import Block, Jump
from stillarm.controller.estimation.fused.consistency import Consistency
from stillarm.controller.estimation.fused.date_watch import DateWatch
from stillarm.controller.estimation.fused.evidence import Evidence
from stillarm.controller.estimation.fused.frame_dates import FrameDates
from stillarm.controller.estimation.fused.fresh_fit import Fresh
from stillarm.controller.estimation.fused.fresh_start import FreshStart, Situation
from stillarm.controller.estimation.fused.held_force import HeldForce, SlowPull
from stillarm.controller.estimation.fused.impact import ImpactReport
from stillarm.controller.estimation.fused.joint_input import JointInput
from stillarm.controller.estimation.fused.layout import Layout
from stillarm.controller.estimation.fused.learnt_force import LearntForce
from stillarm.controller.estimation.fused.learnt_walks import LearntWalks
from stillarm.controller.estimation.fused.reductions import largest
from stillarm.controller.estimation.fused.scale_watch import ScaleWatch
from stillarm.controller.estimation.fused.sensor_health import AccelerometerHealth
from stillarm.controller.estimation.fused.stated_scale import stated_scale, with_stated_scale

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

_OUTLIER = 16.0  # normalised innovation squared
_SUSPICIOUS, _EVIDENT = 7.0, 20.0  # of an impact, by the accelerometer, standard deviations squared
_VOTES = 3
_TELLING = 3.0  # deviations of an image that the vibration moves in a frame: a wrong count shows
_HUBER = 7.0
_BLIND_BLOCKS = 12  # without the accelerometer
_BEFORE_AN_IMPACT = 8  # frames: so many may have been taken in before an impact was noticed
_BREAK_MEMORY_FRAMES = 60.0
_IMPACTS = 1.5  # breaks within that memory that may be impacts
_CLEAR = 0.995
_BENDS = 0.15  # rad: by so uncertain a phase images alone would seem to tell any law's instants
_ZERO_LEARNT = 0.1  # likewise, for it to be remembered
_ZERO_KNOWN = 1.0  # of an image's variance
_SAMPLED_CYCLES = (
    0.4  # standard deviation: a sensor that runs by itself was sampled some time within the last cycle
)
_UNSEEN = 0.001  # of an image's variance, a second: by so much the phasors wander however small the vibration
_NO_RANDOM_FORCE = 1.2  # misfit: such a force would leave more
_DATES_DOUBT = 0.5  # frames: of the dates, where the filters were led astray by what is not known
_PATIENCE_S = 4.0
_STILL = 0.02  # of the vibration's rate: so slow a joint dates no image
_BEFORE_CAUSE = 3.0  # standard deviations: no frame is read before it is exposed
_CLOCKED = (LAW_OF == Law.CLOCK) | (LAW_OF == Law.STAMPS)
_LEARNING = np.where((LAW_OF == Law.DRIFT) | (LAW_OF == Law.JITTER), 0.01, 0.0)  # of the jitter, a frame


class Merged(NamedTuple):
    """The filters' common state: phasors, slow rates, 1/s, accelerometer bias, m, static deflection by a force, m, and
    the covariance of the phasors, with the force behind them where there may be one."""

    phasors: list[complex]
    slow: list[complex]
    bias: float
    bias_variance: float
    force: float
    covariance: list[list[float]]


class BlockToTake(NamedTuple):
    """A block looked at, to be taken in next: FilterBank.take_block."""

    aimed: AimedAtBlock
    variance: float
    shown: tuple[float, float] | None


class Look(NamedTuple):
    """What an image is compared with."""

    value_m: float
    noise: float
    joint_input: JointInput


class Joint(NamedTuple):
    """What the joint did by an image's instants: how far it alone moved the tip, m, at what rate, m/s, both (filters,);
    and the modes' phasor increments since the bank's instant, (filters, m). tip_variance, rate_variance: of both, by
    the encoder's noise, m^2 and m^2/s^2."""

    tip: Array
    rate: Array
    tip_variance: float
    rate_variance: float
    step: ComplexArray


class Aimed(NamedTuple):
    """An image to be foreseen next. times: its instant by each filter, s."""

    image: Look
    times: Array
    received_s: float
    joint: Joint


class PredictedImage(NamedTuple):
    """An image to be looked at next, and what each filter expects it to show."""

    aimed: Aimed
    vibration: Vibration


class Looked(NamedTuple):
    """An image looked at, to be taken in next. times: its instant by each filter, s; surprise: (filters,)."""

    image: Look
    times: Array
    received_s: float
    seen: Seen
    nis: Array


class Taken(NamedTuple):
    """An image taken in, to be settled next. own, s, and spread, s^2: of its own instant, as FilterBank.take_image
    gives them; surprise: as the evidence is to weigh it; each (filters,)."""

    own: Array
    spread: Array
    seen: Seen
    nis: Array
    received_s: float


class FrameFusion:
    """Takes in images and, in their order, the accelerometer's blocks before them.

    delay_s, delay_std_s: of the image looked at last.
    impact: whether the image taken in last was the second one running to break with everything, as after an impact.
    """

    def __init__(
        self, model: Model, settings: Fused, at: Layout, length_m: float, health: AccelerometerHealth
    ) -> None:
        """Nothing seen yet. health: told what the images make of each block of the accelerometer."""
        self.health = health
        self._at = at
        self._frame_s = start.frame_s(model)
        first = start.variances(model, settings, at, length_m)
        self._first_scale = float(first[0, at.scale])
        self._stated_scale = stated_scale(model, self._first_scale)
        self.bank = FilterBank(at, first, start.jitters_s(model))
        self.evidence = Evidence(model, settings, at, length_m)
        self._state_noise = start.state_noise(settings, at)
        self._walks = LearntWalks(at, self._state_noise, LAWS)
        self.dates = FrameDates(model, at, self.bank, self.evidence, self._walks.lead)
        self._scale_watch = ScaleWatch()
        self._phasor_share = start.phasor_share(settings)
        self._carried = np.eye(at.size)[[*range(2 * at.modes), at.force]]
        self._least_jitter = np.where(LAW_OF == Law.JITTER, 0.1, 0.5) * self.bank.jitter
        self._noise_m2 = (at.per_px * model.camera.noise_std_px) ** 2
        self.force = LearntForce(at.w.tolist(), self._noise_m2, health.variance)
        self._sampled_variance = (_SAMPLED_CYCLES * model.timing.cycle_s) ** 2
        self.held_force = HeldForce(at.modes, self._noise_m2, at.period_s)
        self.consistency = Consistency()
        self._date_watch = DateWatch()
        self._nis = 1.0  # normalised innovation squared of the image looked at last
        self._fresh = FreshStart(at, self._noise_m2, self._state_noise, start.spread_s(model))
        self._received_s = 0.0
        self._joint_input: JointInput | None = None
        self._dates_doubted_until_s = float("-inf")
        self._slow_pull = SlowPull(0.5 * at.period_s / self._frame_s)
        self.delay_s = model.timing.capture_delay_s
        self.delay_std_s = start.first_shift_s(model)
        self._arrival_mean, self._arrival_variance = self.delay_s, self.delay_std_s**2
        self.amplitude_m = 0.0
        self._outliers = self._votes = self._voted = 0
        self._images = 0
        self._as_calibrated = True  # neither arm nor scene has changed since the start
        self._late = self._breaks = 0.0
        self.impact = False
        self._unused_blocks = 0
        self._blind = False
        self._before: deque[tuple[float, Array, Array]] = deque(maxlen=_BEFORE_AN_IMPACT)
        self._left: Block | None = None  # looked at, its end not yet reached
        self._left_block: BlockToTake | None = None
        self._aimed: Aimed | None = None
        self._predicted_image: PredictedImage | None = None
        self._looked: Looked | None = None
        self._taken: Taken | None = None
        self._settled: Taken | None = None  # yet to be learnt from

    def take_block(self, block: Block) -> None:
        """Look at the oldest block of the accelerometer not yet taken in; `leave_block` does the rest, before anything
        else changes the bank."""
        self.finish_block()
        bank = self.bank
        for jump in block.jumps:
            bank.inflate(jump, QUIET)
            if jump.force_step_m:
                self.held_force.step(jump.force_step_m)
        held = self.held_force.during(block.start_s, block.end_s)
        if held is not None:
            bank.inflate(held, QUIET)
        push = self.force.during(block.start_s, block.end_s)
        if push is not None:
            bank.inflate(push)
        self._unused_blocks += 1
        if block.count:
            best = self.evidence.best
            value, expected, quadrature, variance = bank.look_at_block(block, best)
            total = variance + block.variance
            health = self.health
            drifted = health.compare(value, expected, total)
            self._date_watch.see(value, expected, quadrature, total)
            if drifted and self._date_watch.shows_offset:
                bank.loosen_bias(drifted)
            if not health.mute:  # what contradicts the images counts less (Huber)
                self._unused_blocks = 0
                self._watch_scale(block, value - expected, expected, total * health.doubt)
                huber = max(1.0, (value - expected) ** 2 / (total + drifted) / _HUBER)
                variance = block.variance * max(huber, health.doubt)
                self._left_block = BlockToTake(bank.aim_at_block(block), variance, self.force.shown(block))
        self._left = block

    def _watch_scale(self, block: Block, difference: float, expected: float, variance: float) -> None:
        # A random force moves images and accelerometer alike: their departures do add up. So do a misled filter's.
        if self.force.intensity or self._fresh.astray(block.end_s):
            self._scale_watch.restart()
        elif self._scale_watch.see(difference, expected, variance, block.end_s - block.start_s):
            self._as_calibrated = False
            self._fresh.remembered.forget()

    def leave_block(self) -> bool:
        """Take in the block looked at last, then, in a second call, move on to its end; False where all is done."""
        if self._left is None:
            return False
        block, bank = self._left, self.bank
        if self._left_block is not None:
            bank.take_block(*self._left_block)
            self._left_block = None
            return True
        self._left = None
        dt = block.end_s - bank.edge_s
        noise = self._state_noise * dt
        noise[:, self._at.scale] += self._scale_watch.grown(dt)
        noise[:, self._at.phasor] = (self._phasor_noise() * dt)[:, None] + block.motion_variance
        bank.move_on(block, noise)
        return True

    def finish_block(self) -> None:
        """All that is left to do with the block looked at last."""
        while self.leave_block():
            pass

    def _phasor_noise(self) -> Array:
        noise: Array = self._phasor_share * self.amplitude_m**2 + _UNSEEN * self._noise_m2
        return noise

    @property
    def _shaken(self) -> bool:
        """Whether a steady random force moves the arm: then nothing tells another force, or a free vibration."""
        return self.force.intensity > 0.0

    def _begin_force(self, time_s: float, size_m: float) -> bool:
        """A force may have begun at that time; whether that can be told: not while the arm is known to be shaken all
        the time, nor before the image's zero is known, from which a force deflects the tip."""
        held, c = self.held_force, self._at.offset
        if not held.may_begin(time_s):
            return False
        if not held.active:
            zero_variance = float(self.bank.p[self.evidence.best, c, c])
            if self._shaken or zero_variance > _ZERO_KNOWN * self._noise_m2:
                return False
            self.bank.give_force(self._slow_pull.followed_m())
        held.begin(time_s, size_m)
        return True

    def held_during(self, start_s: float, end_s: float) -> Jump | None:
        """What a force that lasts may have done to the present between two times."""
        held = self.held_force
        if not held.active:
            return None
        return held.during(start_s, end_s, float(self.evidence.weights[QUIET].sum()))

    def phasor_noise(self) -> float:
        """Growth of the variance of each phasor component, m^2/s."""
        return float(self.evidence.weights @ self._phasor_noise())

    def accept(self, sample: VisualSample, received_s: float) -> bool:
        """Date a frame (also one without a measurement, for its count); False for one not to be used."""
        self.settle()
        self.learn()
        self._finish_dates()
        self.finish_block()
        step_m = self.amplitude_m * self._at.w_first * self._frame_s
        images_tell = self._clock_known and step_m * step_m > _TELLING**2 * self._noise_m2
        return self.dates.accept(sample, received_s, images_tell=images_tell)

    def see_new_zero(self) -> None:
        """The images that follow count from another zero: a force that was held is in it."""
        self.learn()
        self.finish_block()
        if self.held_force.active:
            self.bank.end_force()
            self.held_force.end(self.bank.edge_s, explained=True)
        self.bank.forget_zero()
        self._images = self._outliers = self._votes = 0
        self._slow_pull.restart()
        self._fresh.forget()

    def take_arrival(self) -> None:
        """What the arrival of the frame accepted last tells, if that has not been taken in."""
        if self.dates.take_arrival():
            self._forget_wrong_dates()

    def _forget_wrong_dates(self) -> None:
        """What a wrong clock has taught of the accelerometer is wrong, too."""
        self.health.begin_comparison()
        self._date_watch.restart()
        self._fresh.forget()
        self._scale_watch.restart()
        self._images = self._outliers = self._votes = 0
        self._as_calibrated = True
        self.held_force.end(self.bank.edge_s)
        self._slow_pull.restart()

    def _finish_dates(self) -> None:
        self.take_arrival()
        self.dates.take_started()

    def aim(self, sample: VisualSample, received_s: float, joint_input: JointInput) -> None:
        """A measured frame, accepted before, with all blocks before its exposure taken in: by each filter its instant,
        and what the joint did then. `foresee` comes next, then `look`, before anything else.
        """
        self._finish_dates()
        self.finish_block()
        at, bank = self._at, self.bank
        value = sample.displacement_x_px * at.per_px
        noise = self._noise_m2
        if isfinite(sample.variance_x_px2) and sample.variance_x_px2 > 0.0:
            noise = max(noise, at.per_px**2 * sample.variance_x_px2)
        if self._images == 0:
            bank.x[:, at.offset] = value - at.lever * joint_input.position_at(received_s - self.delay_s)
        self._go_blind(received_s)
        times = self.dates.instants_s + bank.x[:, at.shift]
        image = Look(value, noise, joint_input)
        joint = self._joint(image, times)
        self._joint_input = joint_input
        self._aimed = Aimed(image, times, received_s, joint)

    def predict_image(self) -> None:
        """The vibration that each filter expects of the image aimed at."""
        assert self._aimed is not None
        aimed, self._aimed = self._aimed, None
        self._predicted_image = PredictedImage(aimed, self.bank.vibration_at(aimed.times, aimed.joint.step))

    def look(self, report: ImpactReport) -> bool:
        """The image foreseen; whether it is of use: `take` comes next then, before anything else."""
        assert self._predicted_image is not None
        ((image, times, received_s, joint), vibration), self._predicted_image = self._predicted_image, None
        at, bank, weights = self._at, self.bank, self.evidence.weights
        self._images += 1
        self._breaks *= 1.0 - 1.0 / _BREAK_MEMORY_FRAMES
        seen = self._seen(image, vibration, joint)
        nis = seen.nis
        self.impact = False
        best = self.evidence.best
        self._nis = float(nis[best])
        own = image.noise + joint.tip_variance
        self._fresh.add(self.dates.dating.nominal, image.value_m, own, self._nis, float(seen.variance[best]))
        if nis[self.evidence.best] > _OUTLIER and float(nis[weights > 0.05].min()) > 9.0:
            if not self._explain(image, times, received_s, seen, report):
                self._tell_delay(received_s - times, bank.p[:, at.shift, at.shift] + bank.jitter)
                return False
            times = self.dates.instants_s + bank.x[:, at.shift]
            seen = self._look(image, times)
            nis = np.minimum(seen.nis, 4.0)
        elif not self._blind:
            self._watch_slow_pull(seen, float(times[self.evidence.best]))
        self._outliers = self._votes = 0
        self._looked = Looked(image, times, received_s, seen, nis)
        return True

    def _watch_slow_pull(self, seen: Seen, time_s: float) -> None:
        best = self.evidence.best
        std = sqrt(float(seen.variance[best]))
        c = self._at.offset
        zero_m, variance = float(self.bank.x[best, c]), float(self.bank.p[best, c, c])
        pulled = self._slow_pull.see(float(seen.residual[best]) / std, zero_m, variance)
        if pulled and not self._shaken:
            self._slow_pull.restart()
            if self._begin_force(time_s, 2.0 * std):
                none = (0.0,) * self._at.modes
                self.bank.inflate(Jump(time_s, none, none, 2.0 * std), QUIET)

    def take(self) -> None:
        """Take in the image looked at, if there is one."""
        if self._looked is None:
            return
        (image, times, received_s, seen, nis), self._looked = self._looked, None
        bank, t = self.bank, self._at.shift
        if largest(times) > received_s:
            reach = _BEFORE_CAUSE * np.sqrt(bank.p[:, t, t] + bank.jitter)
            nis = np.where(times - reach > received_s, np.inf, nis)
        # Without accelerometer and joint motion phase and clock look alike; linearised, they would seem to differ.
        phase_only = None
        if self._blind and self._joint_still(image, times):
            phase_only = _CLOCKED | (bank.p[:, t, t] > (_BENDS / self._at.w_first) ** 2)
        own, spread = bank.take_image(seen, np.maximum(1.0, seen.nis / 12.0), phase_only)
        self._taken = Taken(own, spread, seen, nis, received_s)

    def settle(self) -> bool:
        """What the image taken in last tells of the laws and of its delay, before anything else; whether it has.

        `learn` comes next then.
        """
        if self._taken is None:
            return False
        self._settled, self._taken = self._taken, None
        own, spread, seen, nis, received_s = self._settled
        self.evidence.weigh(nis, seen.variance)
        self._tell_delay(received_s - (self.dates.instants_s + self.bank.x[:, self._at.shift] + own), spread)
        self._learn_jitter(own, seen)
        return True

    def learn(self) -> bool:
        """What the image settled last leaves to do before anything else, if there is one. Returns whether the filters
        were found lost, and have begun anew."""
        if self._settled is None:
            return False
        settled, self._settled = self._settled, None
        received_s = settled.received_s
        bank = self.bank
        bank.symmetrise()
        self.evidence.respawn(bank, self.dates.dating, received_s - self.delay_s, self.delay_std_s)
        held, best, f = self.held_force, self.evidence.best, self._at.force
        if held.active and held.see(bank.edge_s, float(bank.x[best, f]), float(bank.p[best, f, f])):
            bank.end_force()
            held.end(bank.edge_s)
        elif held.active and held.oscillates(bank.edge_s):
            bank.end_force()
            held.end(bank.edge_s)
            bank.loosen()
        if self._blind:
            self._before.append((received_s, bank.x.copy(), bank.p.copy()))
        else:
            # by the best filter: what another frequency or decay explains, as with a payload, is no force
            if not self.held_force.moves:
                self.force.see(float(settled.seen.nis[self.evidence.best]))
            self.evidence.remember()
            law = self.evidence.best % LAWS
            self.dates.learn_wander(law)
            self._walks.see(bank, law, self.dates.lead_walk if law == Law.DRIFT else 0.0)
        return self._check(received_s) or self._start_fresh(received_s)

    def _start_fresh(self, received_s: float) -> bool:
        """Start the vibration anew where the filters were led astray, if the last images tell from what."""
        held = self.held_force
        now = Situation(
            received_s, self._nis, self.impact or self._outliers > 0, held.active, held.moves, self._shaken,
            self.consistency.calm and self._zero_known,
            self._date_watch.suspected_rad != 0.0 or self._scale_watch.drifts, self.amplitude_m,
        )  # fmt: skip
        dates = self.dates
        fresh = self._fresh.choose(
            now, dates.changes, self.bank, self.evidence, self._joint_input, dates.shift_noise
        )
        self._received_s = received_s
        if fresh is not None:
            self._begin_with(fresh, received_s)
        return fresh is not None

    @property
    def _zero_known(self) -> bool:
        """Whether the image's zero is known far better than one image tells it."""
        best, c = self.evidence.best, self._at.offset
        return float(self.bank.p[best, c, c]) < _ZERO_LEARNT * self._noise_m2

    def _begin_with(self, fresh: Fresh, now_s: float) -> None:
        bank, held, m = self.bank, self.held_force, self._at.modes
        forced = held.active
        bank.start_vibration(fresh.states, fresh.mean, fresh.covariance, fresh.parts)
        if fresh.parts > 2 * m:
            held.rests(float(fresh.mean[self.evidence.best, 2 * m]), now_s)
        elif held.active:
            held.end(now_s, explained=True)
        self.health.begin_comparison()
        if forced:  # what a force did looked like a phase, another scale, or a random force
            self._date_watch.restart()
            self._scale_watch.begin()
            if fresh.misfit[self.evidence.best] < _NO_RANDOM_FORCE:
                self.force.restart()
        if not self._blind:  # the dates may have been wrong: images cannot tell, the accelerometer will
            bank.doubt_dates((_DATES_DOUBT * self._frame_s) ** 2)
        self._dates_doubted_until_s = now_s + self._at.period_s
        self._slow_pull.restart()
        self._outliers = self._votes = 0

    def _check(self, received_s: float) -> bool:
        bank, at, best = self.bank, self._at, self.evidence.best
        clocked = _CLOCKED[best] and not self.dates.period_found
        skew = float(bank.x[best, at.skew]) if clocked else 0.0
        skew_std = sqrt(max(float(bank.p[best, at.skew, at.skew]), 0.0))
        lost = self.consistency.see(received_s, self._nis, skew, skew_std, self.delay_s)
        lag_rad = self._date_watch.lag_rad
        if lag_rad and not self._shaken:
            bank.redate(-lag_rad / self._at.w_first)
            self._forget_wrong_dates()
            self._images = max(self._images, 1)
            self.consistency.begin(received_s)
            return True
        if (
            lost
            and self._fresh.remembered.known is not None
            and not self.consistency.lost_for(received_s, _PATIENCE_S)
        ):
            return False  # what was known may still explain the images
        if not lost or self._shaken or self.held_force.active:  # what shakes the arm is no wrong date
            return False
        phasors = bank.x[best].copy()
        self.dates.begin_anew(received_s)
        bank.begin_near(phasors)
        self._forget_wrong_dates()
        self._images = 1  # the image's zero is known
        self.consistency.begin(received_s)
        return True

    @property
    def suspected_rad(self) -> float:
        """By what phase of the vibration the frames' dates may be off, by what the accelerometer shows; 0 for none."""
        return self._date_watch.suspected_rad

    @property
    def dates_doubted(self) -> bool:
        """Whether the vibration was lately started anew, and nothing has told why it had to be."""
        return self._received_s < self._dates_doubted_until_s

    @property
    def scale_drifts(self) -> bool:
        """Whether images and accelerometer have lately been found to disagree ever more on how far the tip moves."""
        return self._scale_watch.drifts

    @property
    def blind(self) -> bool:
        """Whether the images are all there is: nothing of the accelerometer has been of use for a while."""
        return self._blind

    def _go_blind(self, received_s: float) -> None:
        """Notice that the accelerometer has gone, or is back."""
        blind = self._unused_blocks > _BLIND_BLOCKS
        if blind and not self._blind:
            instant = received_s - self.delay_s
            self.evidence.go_blind(self.bank, self.dates.dating, instant, self.delay_std_s)
            self._before.clear()
            self._walks.allow_as_assumed()
        elif self._blind and not blind:
            self.evidence.see_again()
        self._blind = blind

    def _explain(
        self, image: Look, times: Array, received_s: float, seen: Seen, report: ImpactReport
    ) -> bool:
        """An image that breaks with everything: wrong by itself, a miscounted frame, an impact. Whether to use it."""
        self._outliers += 1
        if self.held_force.active:
            if self._outliers < 2:
                return False
        elif report.suspicion < _SUSPICIOUS:
            extra = self._other_count(image, times, received_s)
            if extra != self._voted:
                self._votes, self._late = 0, 0.0
            self._votes += int(extra != 0)
            self._voted = extra
            self._late += received_s - float(times[Law.CLOCK]) - self._arrival_mean
            if self._votes < _VOTES and self._outliers <= _VOTES:
                return False
        elif report.suspicion < _EVIDENT and self._outliers < 2:
            return False
        if self._votes >= _VOTES and self._late / (self._voted * self._votes) > 0.6 * self._frame_s:
            self.dates.recount(self._voted)
            return True
        self.impact = True
        best = self.evidence.best
        self._breaks += 1.0
        size = 1.5 * abs(float(seen.residual[best]))
        unseen = report.sees and report.suspicion < _SUSPICIOUS
        # An arm that has changed breaks again and again, and makes the accelerometer contradict, too.
        if (report.in_use and self._breaks > _IMPACTS) or unseen:
            # No impact explains it: a force has begun, or the arm or the scene has changed. The quiet filters take it
            # for the former, the disturbed ones for the latter, and the images decide.
            self.bank.loosen(DISTURBED)
            self._scale_watch.restart()
            self._as_calibrated = False
        if self._blind and self._before:
            then_s, x, p = self._before[0]
            grown = self._state_noise * (received_s - then_s)
            grown[:, self._at.shift] += self.dates.shift_noise * (received_s - then_s)
            self.bank.forget_phase(max(size, 1.5 * self.amplitude_m), x, p, grown)
            self._before.clear()
            return True
        sizes = (size,) + (0.3 * size,) * (self._at.modes - 1)
        force_m = size if self._begin_force(float(times[best]), size) else 0.0
        self.bank.inflate(Jump.guessed(float(times[best]), sizes, force_m), QUIET)
        return True

    @property
    def _clock_known(self) -> bool:
        """Whether the clock's law is possible, and its shift known to a part of a frame."""
        clock = self.evidence.likeliest(Law.CLOCK)
        variance = float(self.bank.p[clock, self._at.shift, self._at.shift])
        return sqrt(variance) <= self._frame_s / 5.0 and self.evidence.law(Law.CLOCK) >= 0.05

    def _other_count(self, image: Look, times: Array, received_s: float) -> int:
        """By how many frames the counter is off if image and arrival agree on it; 0 where they do not.

        A counter of arrivals does not tell of lost frames, nor of a buffer that has begun to hand over older ones.
        """
        if not self._clock_known:
            return 0
        clock, behind = self.evidence.likeliest(Law.CLOCK), self.dates.dating.behind
        costs: list[tuple[float, int]] = []
        for extra in sorted({-2, -1, 1, 2, 3, behind - 1, behind, behind + 1} - {0}):
            moved = times.copy()
            moved[clock] += extra * self._frame_s
            nis = float(self._look(image, moved).nis[clock])
            late = received_s - float(moved[clock]) - self._arrival_mean
            costs.append((nis + late * late / self._arrival_variance, extra))
        cost, extra = min(costs)
        return extra if cost < _OUTLIER else 0

    def _look(self, image: Look, times: Array) -> Seen:
        joint = self._joint(image, times)
        return self._seen(image, self.bank.vibration_at(times, joint.step), joint)

    def _seen(self, image: Look, vibration: Vibration, joint: Joint) -> Seen:
        return self.bank.look(
            image.value_m,
            vibration,
            joint.tip,
            joint.rate,
            joint.rate_variance,
            image.noise + joint.tip_variance,
        )

    def _joint(self, image: Look, times: Array) -> Joint:
        lever = self._at.lever
        theta, rate, step = image.joint_input.seen_from(self.bank.edge_s, times)
        of_tip, of_rate = image.joint_input.position_variance, image.joint_input.rate_variance
        return Joint(theta * lever, rate * lever, lever * lever * of_tip, lever * lever * of_rate, step)

    def _joint_still(self, image: Look, times: Array) -> bool:
        best = self.evidence.best
        _, rate, _ = image.joint_input.seen_from(self.bank.edge_s, times[best : best + 1])
        return abs(float(rate[0])) * self._at.lever < _STILL * self._at.w_first * self.amplitude_m

    def _learn_jitter(self, own: Array, seen: Seen) -> None:
        """Expectation maximisation: the second moment of each frame's own shift after its image, slowly averaged."""
        jitter = self.bank.jitter
        share = seen.rate * jitter
        moment = own * own + jitter - share * share / seen.variance
        self.bank.jitter = np.maximum(jitter + _LEARNING * (moment - jitter), self._least_jitter)

    def _tell_delay(self, delays: Array, spread: Array) -> None:
        w = self.evidence.weights
        mean = float(w @ delays)
        variance = float(w @ (spread + (delays - mean) ** 2))
        self.delay_s, self.delay_std_s = mean, sqrt(variance + self._sampled_variance)
        if variance < (0.2 * self._frame_s) ** 2:
            late = mean - self._arrival_mean
            self._arrival_mean += 0.03 * late
            self._arrival_variance += 0.03 * (late * late - self._arrival_variance)
            self._arrival_variance = max(self._arrival_variance, 0.001**2)

    def merged(self, now_s: float) -> Merged:
        """Phasors at the bank's instant, with the covariance that they have at now_s for want of newer images."""
        self.finish_block()
        bank, at, w = self.bank, self._at, self.evidence.weights
        best = self.evidence.best
        if w[best] > _CLEAR:
            x, p = bank.x[best], bank.p[best]
        else:
            x = w @ bank.x
            d = bank.x - x
            p = (w @ bank.p.reshape(FILTERS, -1)).reshape(at.size, at.size) + (d * w[:, None]).T @ d
        if self._as_calibrated:
            x, p = with_stated_scale(x, p, at.scale, self._first_scale, self._stated_scale)
        m = at.modes
        phasors: list[complex] = (x[at.cosine] - 1j * x[at.sine]).tolist()
        lag = now_s - bank.edge_s
        f = self._carried  # the rows of the phasors
        for i, one in enumerate(phasors):
            by_rate = lag * one
            c, s, kw, kd = 2 * i, 2 * i + 1, 2 * m + i, 3 * m + i
            f[c, kw], f[s, kd] = -by_rate.imag, by_rate.imag
            f[s, kw] = f[c, kd] = -by_rate.real
        rows = 2 * m + int(self.held_force.active)
        f = f[:rows]
        covariance: list[list[float]] = (f @ p @ f.T).tolist()
        noise = self.phasor_noise() * lag
        for i in range(2 * m):
            covariance[i][i] += noise
        self.amplitude_m = sum([abs(one) for one in phasors])
        slow: list[complex] = (-at.sigma - x[at.decay] + 1j * x[at.frequency]).tolist()
        bias = float(x[at.bias]), float(p[at.bias, at.bias])
        return Merged(phasors, slow, *bias, float(x[at.force]), covariance)
