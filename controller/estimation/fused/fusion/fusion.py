"""A frame on its way through the filters, stage by stage: dated, aimed at, predicted, looked at, taken, learnt from.

Implements Eqs. 32, 33, 34, 35, 36 of docs/fused.md.
"""

from math import isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.configuration import Fused
from stillarm.common.files.model import Model
from stillarm.controller.estimation.fused.accelerometer.impact_detector import ImpactReport
from stillarm.controller.estimation.fused.accelerometer.sensor_health import AccelerometerHealth
from stillarm.controller.estimation.fused.arm.joint_input import JointInput
from stillarm.controller.estimation.fused.arm.layout import Layout
from stillarm.controller.estimation.fused.assumptions.assumptions import Assumptions
from stillarm.controller.estimation.fused.filters.image_update import (
    Joint,
    Look,
    Seen,
    Vibration,
    joint_at,
    look_at_image,
    look_at_image_of,
    take_image,
    vibration_at,
)
from stillarm.controller.estimation.fused.filters.laws import CLOCKED, LAW_OF, LAWS, Law
from stillarm.controller.estimation.fused.fusion.block_fusion import BlockFusion
from stillarm.controller.estimation.fused.fusion.force_onset import follow_force, watch_slow_pull
from stillarm.controller.estimation.fused.fusion.image_delay import ImageDelay
from stillarm.controller.estimation.fused.fusion.recovery import Recovery
from stillarm.controller.estimation.fused.fusion.state import fusion_state
from stillarm.controller.estimation.fused.fusion.unexplained_image import UnexplainedImage
from stillarm.controller.estimation.fused.small_arrays import largest

Array = NDArray[np.float64]


class Aimed(NamedTuple):
    """An image to be predicted next. times: its instant by each filter, s."""

    image: Look
    times: Array
    received_s: float
    joint: Joint


class Looked(NamedTuple):
    """An image looked at, to be processed next. times: its instant by each filter, s; nis: (filters,)."""

    image: Look
    times: Array
    received_s: float
    seen: Seen
    nis: Array


class Taken(NamedTuple):
    """An image processed, to be settled next. own, s, and spread, s^2: of its own instant, as image_update.take_image
    gives them; nis: as the evidence is to weigh it; each (filters,)."""

    own: Array
    spread: Array
    seen: Seen
    nis: Array
    received_s: float


class FrameFusion:
    """Processes images and, in their order, the accelerometer's blocks before them.

    A frame passes `accept`, `take_arrival`, `take_started`, and if it is measured `aim`, `predict_image`, `look` and
    `take`; then `settle` and `learn`. blocks: processes the accelerometer's. state: what all parts share. recovery:
    what is begun anew.
    """

    def __init__(
        self,
        model: Model,
        settings: Fused,
        at: Layout,
        length_m: float,
        health: AccelerometerHealth,
        assumed: Assumptions,
    ) -> None:
        """Nothing seen yet. health: told what the images make of each block of the accelerometer."""
        self.state = state = fusion_state(model, settings, at, length_m, health, assumed)
        self.bank, self.evidence, self.dates = state.bank, state.evidence, state.dates
        self.force, self.held_force, self.consistency = state.force, state.held_force, state.consistency
        self.blocks = BlockFusion(state)
        self._delay = ImageDelay(state)
        self._unexplained = UnexplainedImage(state, self._delay)
        self.recovery = Recovery(state, self._unexplained)
        self._assumed = update = assumed.update
        least = np.where(LAW_OF == Law.JITTER, update.least_jitter_own, update.least_jitter)
        self._least_jitter = least * state.bank.jitter
        learns = (LAW_OF == Law.DRIFT) | (LAW_OF == Law.JITTER)
        self._jitter_gain = np.where(learns, update.jitter_gain, 0.0)
        # the image on its way, in what its last stage has made of it
        self._aimed: Aimed | None = None
        self._predicted: tuple[Aimed, Vibration] | None = None
        self._looked: Looked | None = None
        self._taken: Taken | None = None
        self._settled: Taken | None = None

    def accept(self, sample: VisualSample, received_s: float) -> bool:
        """Date a frame (also one without a measurement, for its count); False for one not to be used."""
        self.settle()
        self.learn()
        self._finish_dates()
        self.blocks.finish()
        state = self.state
        step_m = state.amplitude_m * state.at.w_first * state.frame_s
        images_tell = (
            self._unexplained.clock_known
            and step_m * step_m > state.assumed.update.telling_stds**2 * state.image_m2
        )
        return self.dates.accept(sample, received_s, images_tell=images_tell)

    def see_new_zero(self) -> None:
        """The images that follow count from another zero."""
        self.learn()
        self.blocks.finish()
        self.recovery.forget_zero()

    def take_arrival(self) -> None:
        """Measurement update by the arrival of the frame accepted last, unless it was made."""
        if self.dates.take_arrival():
            self.recovery.forget_wrong_dates()

    def _finish_dates(self) -> None:
        self.take_arrival()
        self.dates.take_started()

    def aim(self, sample: VisualSample, received_s: float, joint_input: JointInput) -> None:
        """A measured frame, accepted before, with all blocks before its exposure processed: by each filter its instant,
        and what the joint did then. `predict_image` comes next, then `look`, before anything else."""
        self._finish_dates()
        self.blocks.finish()
        state = self.state
        at, bank = state.at, state.bank
        value = sample.displacement_x_px * at.per_px
        noise = state.image_m2
        if isfinite(sample.variance_x_px2) and sample.variance_x_px2 > 0.0:
            noise = max(noise, at.per_px**2 * sample.variance_x_px2)
        if state.images == 0:
            bank.x[:, at.offset] = value - at.lever * joint_input.position_at(received_s - state.delay_s)
        self._go_blind(received_s)
        times = state.dates.instants_s + bank.x[:, at.shift]
        image = Look(value, noise, joint_input)
        state.joint_input = joint_input
        self._aimed = Aimed(image, times, received_s, joint_at(bank, image, times))

    def predict_image(self) -> None:
        """The vibration that each filter expects of the image aimed at."""
        assert self._aimed is not None
        aimed, self._aimed = self._aimed, None
        self._predicted = aimed, vibration_at(self.bank, aimed.times, aimed.joint.step)

    def look(self, report: ImpactReport) -> bool:
        """The image predicted; whether it is of use: `take` comes next then, before anything else."""
        assert self._predicted is not None
        ((image, times, received_s, joint), vibration), self._predicted = self._predicted, None
        state, unexplained = self.state, self._unexplained
        at, bank, best = state.at, state.bank, state.evidence.best
        state.images += 1
        unexplained.begin_image()
        seen = look_at_image(bank, image, vibration, joint)
        nis = seen.nis
        state.nis = float(nis[best])
        own = image.noise + joint.tip_variance
        state.fresh.add(state.dates.dating.nominal, image.value_m, own, state.nis, float(seen.variance[best]))
        if unexplained.outside_gate(nis):
            if not unexplained.explain(image, times, received_s, seen, report):
                self._delay.tell(received_s - times, bank.p[:, at.shift, at.shift] + bank.jitter)
                return False
            times = state.dates.instants_s + bank.x[:, at.shift]
            seen = look_at_image_of(bank, image, times)
            nis = np.minimum(seen.nis, state.assumed.outlier.afterwards_nis)
        elif not state.blind:
            watch_slow_pull(state, seen, float(times[best]))
        unexplained.end_run()
        self._looked = Looked(image, times, received_s, seen, nis)
        return True

    @property
    def impact(self) -> bool:
        """Whether the image looked at last was taken for the first one after an impact."""
        return self._unexplained.impact

    def take(self) -> None:
        """Process the image looked at, if there is one."""
        if self._looked is None:
            return
        (image, times, received_s, seen, nis), self._looked = self._looked, None
        state = self.state
        bank, t = state.bank, state.at.shift
        if largest(times) > received_s:
            reach = self._assumed.before_cause_stds * np.sqrt(bank.p[:, t, t] + bank.jitter)
            nis = np.where(times - reach > received_s, np.inf, nis)
        # Without accelerometer and joint motion phase and clock look alike; linearised, they would seem to differ.
        phase_only = None
        if state.blind and self._joint_still(image, times):
            phase_only = CLOCKED | (bank.p[:, t, t] > (self._assumed.bends_rad / state.at.w_first) ** 2)
        own, spread = take_image(
            bank, seen, np.maximum(1.0, seen.nis / self._assumed.image_huber_nis), phase_only
        )
        self._taken = Taken(own, spread, seen, nis, received_s)

    def settle(self) -> bool:
        """Weigh the laws and tell the delay by the image processed last, before anything else; whether there was one.

        `learn` comes next then.
        """
        if self._taken is None:
            return False
        taken, self._taken = self._taken, None
        own, spread, seen, nis, received_s = taken
        state = self.state
        state.evidence.weigh(nis, seen.variance)
        delays = received_s - (state.dates.instants_s + state.bank.x[:, state.at.shift] + own)
        self._delay.tell(delays, spread)
        self._learn_jitter(own, seen)
        self._settled = taken
        return True

    def learn(self) -> bool:
        """Learn from the image settled last, if there is one, before anything else.

        Returns whether the filters were found lost and have started again.
        """
        if self._settled is None:
            return False
        settled, self._settled = self._settled, None
        state, received_s = self.state, settled.received_s
        bank, evidence = self.bank, self.evidence
        bank.symmetrise()
        evidence.respawn(bank, self.dates.dating, received_s - state.delay_s, state.delay_std_s)
        follow_force(state)
        if state.blind:
            self._unexplained.remember(received_s)
        else:
            # by the best filter: what another frequency or decay explains, as with a payload, is no force
            if not self.held_force.moves:
                self.force.see(float(settled.seen.nis[evidence.best]))
            evidence.remember()
            law = evidence.best % LAWS
            self.dates.learn_wander(law)
            state.walks.see(bank, law, self.dates.lead_walk if law == Law.DRIFT else 0.0)
        best, e = evidence.best, state.at.scale
        whose = best, bank.moved[best]
        state.scale_watch.see_scale(float(bank.x[best, e]), float(bank.p[best, e, e]), whose)
        return self.recovery.recover(received_s)

    def _joint_still(self, image: Look, times: Array) -> bool:
        """Whether the joint moves too slowly to date the image, by the most likely filter."""
        state, best = self.state, self.evidence.best
        _, rate, _ = image.joint_input.seen_from(state.bank.edge_s, times[best : best + 1])
        return (
            abs(float(rate[0])) * state.at.lever < self._assumed.still * state.at.w_first * state.amplitude_m
        )

    def _learn_jitter(self, own: Array, seen: Seen) -> None:
        """Expectation maximisation: the second moment of each frame's own shift after its image, slowly averaged."""
        bank = self.bank
        jitter = bank.jitter
        share = seen.rate * jitter
        moment = own * own + jitter - share * share / seen.variance
        bank.jitter = np.maximum(jitter + self._jitter_gain * (moment - jitter), self._least_jitter)

    def _go_blind(self, received_s: float) -> None:
        """Notice that the accelerometer has gone, or is back."""
        state = self.state
        blind = state.unused_blocks > self._assumed.blind_blocks
        if blind and not state.blind:
            instant = received_s - state.delay_s
            state.evidence.go_blind(state.bank, state.dates.dating, instant, state.delay_std_s)
            self._unexplained.forget_before()
            state.walks.allow_as_assumed()
        elif state.blind and not blind:
            state.evidence.see_again()
        state.blind = blind
