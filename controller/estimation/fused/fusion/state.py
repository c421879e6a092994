"""State that the parts of the fusion share: the filters, what is learnt beside them, and facts of the last image.

Implements Eq. 43 of docs/fused.md.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.configuration import Fused
from stillarm.common.files.model import Model
from stillarm.controller.estimation.fused.accelerometer.blocks import Jump
from stillarm.controller.estimation.fused.accelerometer.sensor_health import AccelerometerHealth
from stillarm.controller.estimation.fused.arm.joint_input import JointInput
from stillarm.controller.estimation.fused.arm.layout import Layout
from stillarm.controller.estimation.fused.assumptions.assumptions import Assumptions
from stillarm.controller.estimation.fused.dates.evidence import Evidence
from stillarm.controller.estimation.fused.dates.frame_dates import FrameDates
from stillarm.controller.estimation.fused.filters import start
from stillarm.controller.estimation.fused.filters.bank import FilterBank
from stillarm.controller.estimation.fused.filters.laws import LAWS, QUIET
from stillarm.controller.estimation.fused.learning.held_force import HeldForce, SlowPull
from stillarm.controller.estimation.fused.learning.learnt_force import LearntForce
from stillarm.controller.estimation.fused.learning.learnt_walks import LearntWalks
from stillarm.controller.estimation.fused.learning.scale_watch import ScaleWatch
from stillarm.controller.estimation.fused.learning.stated_scale import Stated, stated_scale
from stillarm.controller.estimation.fused.recovery.consistency import Consistency
from stillarm.controller.estimation.fused.recovery.date_watch import DateWatch
from stillarm.controller.estimation.fused.recovery.fresh_start import FreshStart

Array = NDArray[np.float64]


@dataclass(slots=True)
class FusionState:
    """image_m2: variance of an image's noise, m^2. state_noise: growth of the states' variances, (filters, n), 1/s;
    phasor_share: of the phasors' deviation as a share of the amplitude, squared, (filters,), 1/s. first_scale: the
    filters' variance of the image scale's error beforehand; stated_scale: what the model says of it.

    amplitude_m: of the vibration, by the filters' mixture. images: processed since the image's zero was forgotten.
    outliers: images running outside the gate of all filters. nis: normalised innovation squared of the last image.
    delay_s, delay_std_s: of that image. sampled_s: standard deviation of the instant within a cycle at which a sample
    was taken; the delay and the deflection's instant are uncertain by it. as_calibrated: whether neither arm nor scene
    has changed since the start; unless_forced: whether that was given up for something that a force may explain yet.
    unused_blocks: blocks running that told nothing; blind: whether the accelerometer has told nothing for a while.
    joint_input: what the joint did, None before the first image. zero_m: how far the image's zero has moved where the
    joint holds the tip, m, since zero_then: the filter it was seen by, zero and scale.
    """

    assumed: Assumptions
    at: Layout
    frame_s: float
    image_m2: float
    health: AccelerometerHealth
    bank: FilterBank
    evidence: Evidence
    dates: FrameDates
    walks: LearntWalks
    force: LearntForce
    held_force: HeldForce
    slow_pull: SlowPull
    scale_watch: ScaleWatch
    date_watch: DateWatch
    first_scale: float
    stated_scale: Stated
    consistency: Consistency
    fresh: FreshStart
    state_noise: Array
    phasor_share: Array
    sampled_s: float
    delay_s: float
    delay_std_s: float
    amplitude_m: float = 0.0
    images: int = 0
    outliers: int = 0
    nis: float = 1.0
    as_calibrated: bool = True
    unless_forced: bool = False
    unused_blocks: int = 0
    blind: bool = False
    joint_input: JointInput | None = None
    zero_m: float = 0.0
    zero_then: tuple[int, float, float] = (-1, 0.0, 0.0)

    @property
    def held_m(self) -> float:
        """How far the joint alone holds the tip from where it began, m."""
        joint = self.joint_input
        return 0.0 if joint is None else self.at.lever * joint.position_at(self.bank.edge_s)

    @property
    def shaken(self) -> bool:
        """Whether a steady random force moves the arm: then nothing tells another force, or a free vibration."""
        return self.force.random

    def held_during(self, start_s: float, end_s: float) -> Jump | None:
        """What a force that lasts may have done to the present between two times."""
        held = self.held_force
        if not held.active:
            return None
        return held.during(start_s, end_s, float(self.evidence.weights[QUIET].sum()))

    def phasor_noise(self) -> Array:
        """Growth of the variance of each phasor component by each filter, m^2/s, (filters,)."""
        noise: Array = self.phasor_share * self.amplitude_m**2 + self.assumed.update.unseen * self.image_m2
        return noise


def fusion_state(
    model: Model,
    settings: Fused,
    at: Layout,
    length_m: float,
    health: AccelerometerHealth,
    assumed: Assumptions,
) -> FusionState:
    """Nothing seen yet. health: told what the images make of each block of the accelerometer."""
    frame_s = start.frame_s(model)
    bank = FilterBank(
        at, start.variances(model, settings, at, length_m, assumed), start.jitters_s(model, assumed), assumed
    )
    first_scale = float(bank.first[0, at.scale])
    evidence = Evidence(model, settings, at, length_m, assumed)
    state_noise = start.state_noise(settings, at, assumed)
    walks = LearntWalks(at, state_noise, LAWS, assumed)
    dates = FrameDates(model, at, bank, evidence, walks.lead, assumed)
    shift_spread_s = start.spread_s(model, assumed)
    image_m2 = (at.per_px * model.camera.noise_std_px) ** 2
    return FusionState(
        assumed=assumed,
        at=at,
        frame_s=frame_s,
        image_m2=image_m2,
        health=health,
        bank=bank,
        evidence=evidence,
        dates=dates,
        walks=walks,
        force=LearntForce(at.w.tolist(), image_m2, health.variance, model.timing.cycle_s, assumed),
        held_force=HeldForce(at.modes, image_m2, at.period_s, assumed),
        slow_pull=SlowPull(0.5 * at.period_s / frame_s, assumed),
        scale_watch=ScaleWatch(assumed),
        date_watch=DateWatch(assumed),
        first_scale=first_scale,
        stated_scale=stated_scale(model, first_scale, assumed.scale),
        consistency=Consistency(assumed),
        fresh=FreshStart(at, image_m2, state_noise, shift_spread_s, bank, dates, evidence, assumed),
        state_noise=state_noise,
        phasor_share=start.phasor_share(settings, assumed),
        sampled_s=assumed.update.sampled_cycles * model.timing.cycle_s,
        delay_s=model.timing.capture_delay_s,
        delay_std_s=start.first_shift_s(model, assumed),
    )
