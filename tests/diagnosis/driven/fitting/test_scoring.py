"""The score of a residual: an exact one is worth more, and the mean of a block nothing."""

import numpy as np

from stillarm.diagnosis.driven.fitting.scoring import scored
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.recording.signals import Driven, Output

STEP_S, SAMPLES = 0.01, 3000
NAME = "joint_position_rad"


def test_a_smaller_residual_is_worth_its_logarithm_and_a_blocks_mean_nothing() -> None:
    rng = np.random.default_rng(2)
    noise = rng.standard_normal(SAMPLES)
    seen = Output(NAME, "position", rng.standard_normal(SAMPLES), True, 0.0)
    driven = Driven("x", STEP_S, 0.0, "motor_voltage_v", noise, True, (seen,), {})
    box = GreyBox(driven, irregular(driven.duration_s))
    plain, half, moved = (
        scored(box, {NAME: one})[1].sum() for one in (noise, 0.5 * noise, noise + 3.0 * box.block)
    )
    counted = SAMPLES - len(box.split.held)  # a block's mean counts for nothing
    assert abs(half - plain - counted * np.log(2.0)) < 0.02 * counted
    assert abs(moved - plain) < 1e-6 * abs(plain)
