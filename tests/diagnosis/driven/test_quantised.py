"""An encoder's steps, and what counts beside them."""

import numpy as np

from stillarm.diagnosis.driven.blocks import irregular
from stillarm.diagnosis.driven.fitting import DrivenFit, fit
from stillarm.diagnosis.driven.greybox import GreyBox
from stillarm.diagnosis.driven.quantised import CAUSE, beyond_half_a_step, quantised
from stillarm.diagnosis.driven.signals import Driven, Output, counter_step

STEP_S, NAME, COUNT = 0.01, "joint_position_rad", 0.2
NUMBERS = {"gain": 1.0, "damping": 0.5}


def _fitted(torque: float) -> DrivenFit:
    """A joint whose angle is counted in coarse steps, fitted without a constant torque that it may have."""
    u = np.random.default_rng(4).standard_normal(2000)
    u = np.convolve(u, np.ones(60) / 10.0, mode="same")
    blind = Output(NAME, "position", np.zeros(2000), True, COUNT)
    driven = Driven("x", STEP_S, 0.0, "joint_torque_n_m", u, True, (blind,), {})
    split = irregular(driven.duration_s)
    free = GreyBox(driven, split)
    angle = free.run({**NUMBERS, "offset": torque}, np.zeros((len(split.held), 2))).outputs[NAME]
    counted = COUNT * np.rint(angle / COUNT)
    seen = Output(NAME, "position", counted, True, counter_step(counted))
    box = GreyBox(Driven("x", STEP_S, 0.0, "joint_torque_n_m", u, True, (seen,), {}), split)
    return fit(box, NUMBERS, (), np.zeros((len(split.held), 2)), steps=0)


def test_a_counted_angle_is_named_by_its_step() -> None:
    found = quantised(_fitted(0.0))
    assert found is not None
    form, channel, step, reduction = found
    assert form.cause == CAUSE and channel == NAME and abs(step / COUNT - 1.0) < 1e-6 and reduction > 0.2


def test_what_rounding_leaves_is_no_departure_and_what_is_more_than_that_stays_one() -> None:
    rounded, off = _fitted(0.0), _fitted(3.0)

    def lost(fitted: DrivenFit) -> float:
        return float((beyond_half_a_step(fitted, NAME).whole - fitted.whole).sum())

    exact = beyond_half_a_step(rounded, NAME)
    assert (exact.whole >= beyond_half_a_step(off, NAME).whole).all()
    assert lost(rounded) >= 0.0
    assert float(exact.whole.sum() - beyond_half_a_step(off, NAME).whole.sum()) > 100.0
