"""One image processed by the filters: aimed at, predicted, looked at, taken, settled, each when there is time for it.

Implements Eqs. 32, 33, 34, 35, 36 of docs/fused.md.
"""

from math import isfinite

import numpy as np
from numpy.typing import NDArray

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.controller.estimation.fused.accelerometer.impact_detector import ImpactReport
from stillarm.controller.estimation.fused.arm.joint_input import JointInput
from stillarm.controller.estimation.fused.filters.image_update import Seen, take_image, vibration_at
from stillarm.controller.estimation.fused.filters.laws import CLOCKED, LAW_OF, Law
from stillarm.controller.estimation.fused.fusion.force_onset import watch_slow_pull
from stillarm.controller.estimation.fused.fusion.image_delay import ImageDelay
from stillarm.controller.estimation.fused.fusion.image_stages import (
    Aimed,
    Look,
    Looked,
    PredictedImage,
    Taken,
    compared,
    compared_at,
    joint_at,
    joint_still,
)
from stillarm.controller.estimation.fused.fusion.state import FusionState
from stillarm.controller.estimation.fused.fusion.unexplained_image import UnexplainedImage
from stillarm.controller.estimation.fused.small_arrays import largest

Array = NDArray[np.float64]


class ImageFusion:
    """Holds the image on its way, in what its last stage has made of it."""

    def __init__(self, state: FusionState, unexplained: UnexplainedImage, delay: ImageDelay) -> None:
        """No image is waiting. unexplained: told of images outside their gate; delay: of each image's delay."""
        self._state, self._unexplained, self._delay = state, unexplained, delay
        self._assumed = assumed = state.assumed.update
        least = np.where(LAW_OF == Law.JITTER, assumed.least_jitter_own, assumed.least_jitter)
        self._least_jitter = least * state.bank.jitter
        learns = (LAW_OF == Law.DRIFT) | (LAW_OF == Law.JITTER)
        self._jitter_gain = np.where(learns, assumed.jitter_gain, 0.0)
        self._aimed: Aimed | None = None
        self._predicted: PredictedImage | None = None
        self._looked: Looked | None = None
        self._taken: Taken | None = None

    def aim(self, sample: VisualSample, received_s: float, joint_input: JointInput) -> None:
        """A measured frame, dated before, with all blocks before its exposure processed: by each filter its instant,
        and what the joint did then. `predict` comes next, then `look`, before anything else."""
        state = self._state
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
        self._aimed = Aimed(image, times, received_s, joint_at(state, image, times))

    def predict(self) -> None:
        """The vibration that each filter expects of the image aimed at."""
        assert self._aimed is not None
        aimed, self._aimed = self._aimed, None
        self._predicted = PredictedImage(aimed, vibration_at(self._state.bank, aimed.times, aimed.joint.step))

    def look(self, report: ImpactReport) -> bool:
        """The image predicted; whether it is of use: `take` comes next then, before anything else."""
        assert self._predicted is not None
        ((image, times, received_s, joint), vibration), self._predicted = self._predicted, None
        state, unexplained = self._state, self._unexplained
        at, bank, best = state.at, state.bank, state.evidence.best
        state.images += 1
        unexplained.begin_image()
        seen = compared(state, image, vibration, joint)
        nis = seen.nis
        state.nis = float(nis[best])
        own = image.noise + joint.tip_variance
        state.fresh.add(state.dates.dating.nominal, image.value_m, own, state.nis, float(seen.variance[best]))
        if unexplained.outside_gate(nis):
            if not unexplained.explain(image, times, received_s, seen, report):
                self._delay.tell(received_s - times, bank.p[:, at.shift, at.shift] + bank.jitter)
                return False
            times = state.dates.instants_s + bank.x[:, at.shift]
            seen = compared_at(state, image, times)
            nis = np.minimum(seen.nis, state.assumed.outlier.afterwards_nis)
        elif not state.blind:
            watch_slow_pull(state, seen, float(times[best]))
        unexplained.end_run()
        self._looked = Looked(image, times, received_s, seen, nis)
        return True

    def take(self) -> None:
        """Process the image looked at, if there is one."""
        if self._looked is None:
            return
        (image, times, received_s, seen, nis), self._looked = self._looked, None
        state = self._state
        bank, t = state.bank, state.at.shift
        if largest(times) > received_s:
            reach = self._assumed.before_cause_stds * np.sqrt(bank.p[:, t, t] + bank.jitter)
            nis = np.where(times - reach > received_s, np.inf, nis)
        # Without accelerometer and joint motion phase and clock look alike; linearised, they would seem to differ.
        phase_only = None
        if state.blind and joint_still(state, image, times):
            phase_only = CLOCKED | (bank.p[:, t, t] > (self._assumed.bends_rad / state.at.w_first) ** 2)
        own, spread = take_image(
            bank, seen, np.maximum(1.0, seen.nis / self._assumed.image_huber_nis), phase_only
        )
        self._taken = Taken(own, spread, seen, nis, received_s)

    def settle(self) -> Taken | None:
        """What the image processed last tells of the laws and of its delay, before anything else; that image."""
        if self._taken is None:
            return None
        taken, self._taken = self._taken, None
        own, spread, seen, nis, received_s = taken
        state = self._state
        state.evidence.weigh(nis, seen.variance)
        delays = received_s - (state.dates.instants_s + state.bank.x[:, state.at.shift] + own)
        self._delay.tell(delays, spread)
        self._learn_jitter(own, seen)
        return taken

    def _learn_jitter(self, own: Array, seen: Seen) -> None:
        """Expectation maximisation: the second moment of each frame's own shift after its image, slowly averaged."""
        bank = self._state.bank
        jitter = bank.jitter
        share = seen.rate * jitter
        moment = own * own + jitter - share * share / seen.variance
        bank.jitter = np.maximum(jitter + self._jitter_gain * (moment - jitter), self._least_jitter)

    def _go_blind(self, received_s: float) -> None:
        """Notice that the accelerometer has gone, or is back."""
        state = self._state
        blind = state.unused_blocks > self._assumed.blind_blocks
        if blind and not state.blind:
            instant = received_s - state.delay_s
            state.evidence.go_blind(state.bank, state.dates.dating, instant, state.delay_std_s)
            self._unexplained.forget_before()
            state.walks.allow_as_assumed()
        elif state.blind and not blind:
            state.evidence.see_again()
        state.blind = blind
