"""A frame's stages in the filters: it is dated, prepared, predicted, compared, updated, weighed and learnt from.

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
    ImageInnovation,
    Joint,
    ObservedImage,
    Vibration,
    compare_image,
    compare_image_at,
    joint_at,
    update_by_image,
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


class Prepared(NamedTuple):
    """An image to be predicted next. times: its instant by each filter, s."""

    image: ObservedImage
    times: Array
    received_s: float
    joint: Joint


class Compared(NamedTuple):
    """An image compared, to be processed next. times: its instant by each filter, s; nis: (filters,)."""

    image: ObservedImage
    times: Array
    received_s: float
    innovation: ImageInnovation
    nis: Array


class Updated(NamedTuple):
    """An image processed, to be weighed next. own, s, and spread, s^2: of its own instant, as update_by_image returns
    them; nis: as the evidence is to weigh it; each (filters,)."""

    own: Array
    spread: Array
    innovation: ImageInnovation
    nis: Array
    received_s: float


class FrameFusion:
    """Processes images and, in their order, the accelerometer's blocks before them.

    A frame passes `accept`, `update_by_arrival`, `dates.update_by_started`, and if it is measured `prepare`,
    `predict_image`, `compare` and `update`; then `weigh` and `learn`. blocks: processes the accelerometer's. state:
    shared by all parts. recovery: restarts.
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
        self._prepared: Prepared | None = None
        self._predicted: tuple[Prepared, Vibration] | None = None
        self._compared: Compared | None = None
        self._updated: Updated | None = None
        self._weighed: Updated | None = None

    def accept(self, sample: VisualSample, received_s: float) -> bool:
        """Date a frame (also one without a measurement, for its count); False for one not to be used."""
        self.weigh()
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
        """The images that follow come from another supervisor, and count from another zero."""
        self.learn()
        self._finish_dates()
        self.blocks.finish()
        self.recovery.forget_zero()
        self.dates.arrive_anew()

    def update_by_arrival(self) -> None:
        """Measurement update by the arrival of the frame accepted last, unless it was made."""
        if self.dates.update_by_arrival():
            self.recovery.forget_wrong_dates()

    def _finish_dates(self) -> None:
        self.update_by_arrival()
        self.dates.update_by_started()

    def prepare(self, sample: VisualSample, received_s: float, joint_input: JointInput) -> None:
        """Prepare a measured frame, accepted before, with all blocks before its exposure processed: its instant by each
        filter, and what the joint did then. `predict_image` comes next, then `compare`, before anything else."""
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
        image = ObservedImage(value, noise, joint_input)
        state.joint_input = joint_input
        self._prepared = Prepared(image, times, received_s, joint_at(bank, image, times))

    def predict_image(self) -> None:
        """Predict the vibration that the prepared image shows, by each filter."""
        assert self._prepared is not None
        prepared, self._prepared = self._prepared, None
        self._predicted = prepared, vibration_at(self.bank, prepared.times, prepared.joint.step)

    def compare(self, report: ImpactReport) -> bool:
        """Compare the predicted image; whether it is of use. If so, `update` comes next, before anything else."""
        assert self._predicted is not None
        ((image, times, received_s, joint), vibration), self._predicted = self._predicted, None
        state, unexplained = self.state, self._unexplained
        at, bank, best = state.at, state.bank, state.evidence.best
        state.images += 1
        unexplained.begin_image()
        innovation = compare_image(bank, image, vibration, joint)
        nis = innovation.nis
        state.nis = float(nis[best])
        own = image.noise + joint.tip_variance
        state.fresh.add(
            state.dates.dating.nominal, image.value_m, own, state.nis, float(innovation.variance[best])
        )
        if unexplained.outside_gate(nis):
            if not unexplained.explain(image, times, received_s, innovation, report):
                self._delay.tell(received_s - times, bank.p[:, at.shift, at.shift] + bank.jitter)
                return False
            times = state.dates.instants_s + bank.x[:, at.shift]
            innovation = compare_image_at(bank, image, times)
            nis = np.minimum(innovation.nis, state.assumed.outlier.afterwards_nis)
        elif not state.blind:
            watch_slow_pull(state, innovation, float(times[best]))
        unexplained.end_run()
        self._compared = Compared(image, times, received_s, innovation, nis)
        return True

    @property
    def impact(self) -> bool:
        """Whether the image compared last counts as the first one after an impact."""
        return self._unexplained.impact

    def update(self) -> None:
        """Measurement update by the image compared, if there is one."""
        if self._compared is None:
            return
        (image, times, received_s, innovation, nis), self._compared = self._compared, None
        state = self.state
        bank, t = state.bank, state.at.shift
        if largest(times) > received_s:
            reach = self._assumed.before_cause_stds * np.sqrt(bank.p[:, t, t] + bank.jitter)
            nis = np.where(times - reach > received_s, np.inf, nis)
        # Without accelerometer and joint motion phase and clock look alike; linearised, they would seem to differ.
        phase_only = None
        if state.blind and self._joint_still(image, times):
            phase_only = CLOCKED | (bank.p[:, t, t] > (self._assumed.bends_rad / state.at.w_first) ** 2)
        own, spread = update_by_image(
            bank, innovation, np.maximum(1.0, innovation.nis / self._assumed.image_huber_nis), phase_only
        )
        self._updated = Updated(own, spread, innovation, nis, received_s)

    def weigh(self) -> bool:
        """Weigh the laws and tell the delay by the image processed last, before anything else; whether there was one.

        `learn` comes next then.
        """
        if self._updated is None:
            return False
        updated, self._updated = self._updated, None
        own, spread, innovation, nis, received_s = updated
        state = self.state
        state.evidence.weigh(nis, innovation.variance)
        delays = received_s - (state.dates.instants_s + state.bank.x[:, state.at.shift] + own)
        self._delay.tell(delays, spread)
        self._learn_jitter(own, innovation)
        self._weighed = updated
        return True

    def learn(self) -> bool:
        """Learn from the image weighed last, if there is one, before anything else.

        Returns whether the filters were found lost and have started again.
        """
        if self._weighed is None:
            return False
        weighed, self._weighed = self._weighed, None
        state, received_s = self.state, weighed.received_s
        bank, evidence = self.bank, self.evidence
        bank.symmetrise()
        evidence.respawn(bank, self.dates.dating, received_s - state.delay_s, state.delay_std_s)
        follow_force(state)
        if state.blind:
            self._unexplained.remember(received_s)
        else:
            # by the best filter: what another frequency or decay explains, as with a payload, is no force
            if not self.held_force.moves:
                self.force.see(float(weighed.innovation.nis[evidence.best]))
            evidence.remember()
            law = evidence.best % LAWS
            self.dates.learn_wander(law)
            state.walks.see(bank, law, self.dates.lead_walk if law == Law.DRIFT else 0.0)
        best, e = evidence.best, state.at.scale
        whose = best, bank.moved[best]
        state.scale_watch.see_scale(float(bank.x[best, e]), float(bank.p[best, e, e]), whose)
        return self.recovery.recover(received_s)

    def _joint_still(self, image: ObservedImage, times: Array) -> bool:
        """Whether the joint moves too slowly to date the image, by the most likely filter."""
        state, best = self.state, self.evidence.best
        _, rate, _ = image.joint_input.seen_from(state.bank.edge_s, times[best : best + 1])
        return (
            abs(float(rate[0])) * state.at.lever < self._assumed.still * state.at.w_first * state.amplitude_m
        )

    def _learn_jitter(self, own: Array, innovation: ImageInnovation) -> None:
        """Expectation maximisation: the second moment of each frame's own shift after its image, slowly averaged."""
        bank = self.bank
        jitter = bank.jitter
        share = innovation.rate * jitter
        moment = own * own + jitter - share * share / innovation.variance
        bank.jitter = np.maximum(jitter + self._jitter_gain * (moment - jitter), self._least_jitter)

    def _go_blind(self, received_s: float) -> None:
        """Notice that the accelerometer has gone, or is back."""
        state = self.state
        blind = state.unused_blocks > self._assumed.blind_blocks
        if blind != state.blind:
            state.dates.follow_started(early=blind)
        if blind and not state.blind:
            instant = received_s - state.delay_s
            state.evidence.go_blind(state.bank, state.dates.dating, instant, state.delay_std_s)
            self._unexplained.forget_before()
            state.walks.allow_as_assumed()
        elif state.blind and not blind:
            state.evidence.see_again()
        state.blind = blind
