"""Images in their order with the accelerometer's blocks before them, and what follows for the delay.

Passes a frame on from Eq. 18 to Eq. 41 of docs/fused.md.
"""

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.configuration import Fused
from stillarm.common.files.model import Model
from stillarm.controller.estimation.fused.accelerometer.blocks import Jump
from stillarm.controller.estimation.fused.accelerometer.impact_detector import ImpactReport
from stillarm.controller.estimation.fused.accelerometer.sensor_health import AccelerometerHealth
from stillarm.controller.estimation.fused.arm.joint_input import JointInput
from stillarm.controller.estimation.fused.arm.layout import Layout
from stillarm.controller.estimation.fused.assumptions.assumptions import Assumptions
from stillarm.controller.estimation.fused.filters.jumps import end_force, forget_zero
from stillarm.controller.estimation.fused.filters.laws import LAWS, QUIET, Law
from stillarm.controller.estimation.fused.fusion.block_fusion import BlockFusion
from stillarm.controller.estimation.fused.fusion.force_onset import follow_force
from stillarm.controller.estimation.fused.fusion.image_delay import ImageDelay
from stillarm.controller.estimation.fused.fusion.image_fusion import ImageFusion
from stillarm.controller.estimation.fused.fusion.image_stages import Taken
from stillarm.controller.estimation.fused.fusion.mixture import Merged, Mixture
from stillarm.controller.estimation.fused.fusion.recovery import Recovery
from stillarm.controller.estimation.fused.fusion.state import fusion_state
from stillarm.controller.estimation.fused.fusion.unexplained_image import UnexplainedImage
from stillarm.controller.estimation.fused.learning.stated_scale import stated_scale


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
        delay = ImageDelay(state)
        self._unexplained = UnexplainedImage(state, delay)
        self._image = ImageFusion(state, self._unexplained, delay)
        self.recovery = Recovery(state, self._unexplained)
        first_scale = float(self.bank.first[0, at.scale])
        self._mixture = Mixture(state, first_scale, stated_scale(model, first_scale, assumed.scale))
        self.predict_image, self.phasor_noise = self._image.predict, self._mixture.phasor_noise
        self._settled: Taken | None = None  # yet to be learnt from

    @property
    def delay_s(self) -> float:
        """Of the image looked at last, s."""
        return self.state.delay_s

    @property
    def delay_std_s(self) -> float:
        """Of the image looked at last, s."""
        return self.state.delay_std_s

    def held_during(self, start_s: float, end_s: float) -> Jump | None:
        """What a force that lasts may have done to the present between two times."""
        held = self.held_force
        if not held.active:
            return None
        return held.during(start_s, end_s, float(self.evidence.weights[QUIET].sum()))

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
        """The images that follow count from another zero: a force that was held is in it."""
        self.learn()
        self.blocks.finish()
        if self.held_force.active:
            end_force(self.bank)
            self.held_force.end(self.bank.edge_s, explained=True)
        forget_zero(self.bank)
        self.state.images = 0
        self._unexplained.end_run()
        self.state.slow_pull.restart()
        self.state.fresh.forget()

    def take_arrival(self) -> None:
        """What the arrival of the frame accepted last tells, if that has not been processed."""
        if self.dates.take_arrival():
            self.recovery.forget_wrong_dates()

    def _finish_dates(self) -> None:
        self.take_arrival()
        self.dates.take_started()

    def aim(self, sample: VisualSample, received_s: float, joint_input: JointInput) -> None:
        """A measured frame, accepted before, with all blocks before its exposure processed: ImageFusion.aim."""
        self._finish_dates()
        self.blocks.finish()
        self._image.aim(sample, received_s, joint_input)

    def look(self, report: ImpactReport) -> bool:
        """The image predicted; whether it is of use: `take` comes next then, before anything else."""
        return self._image.look(report)

    @property
    def impact(self) -> bool:
        """Whether the image looked at last was taken for the first one after an impact."""
        return self._unexplained.impact

    def take(self) -> None:
        """Process the image looked at, if there is one."""
        self._image.take()

    def settle(self) -> bool:
        """What the image processed last tells of the laws and of its delay, before anything else; whether it has.

        `learn` comes next then.
        """
        taken = self._image.settle()
        if taken is None:
            return False
        self._settled = taken
        return True

    def learn(self) -> bool:
        """What the image settled last leaves to do before anything else, if there is one. Returns whether the filters
        were found lost, and have begun anew."""
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

    def merged(self, now_s: float) -> Merged:
        """Phasors at the bank's instant, with the covariance that they have at now_s for want of newer images."""
        self.blocks.finish()
        return self._mixture.merged(now_s)
