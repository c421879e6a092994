"""What a form takes away, where it acts at the tops of the motion alone, and where it acts throughout."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.driven.decision.mended import mended_most, share_mended
from stillarm.diagnosis.driven.fitting.fitting import DrivenFit, fit
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.mechanisms.mechanisms import FORMS
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.recording.signals import Driven, Output

NAME, SAMPLES = "joint_position_rad", 900
LIMIT, OFFSET = (next(one for one in FORMS if one.numbers == (name,)) for name in ("limit", "offset"))


def _after() -> DrivenFit:
    seen = Output(NAME, "position", np.arange(SAMPLES) * 0.01, True, 0.0)
    driven = Driven("x", 0.01, 0.0, "motor_voltage_v", np.ones(SAMPLES), True, (seen,), {})
    numbers = {"gain": 1.0, "damping": 0.0, "delay": 0.0}
    fitted = fit(GreyBox(driven, irregular(9.0)), numbers, (), steps=0)
    return replace(fitted, residuals={NAME: np.where(np.arange(SAMPLES) % 2, 1.0, -1.0)})


def test_a_limit_counts_where_it_acts_though_it_was_not_held_out() -> None:
    after = _after()
    block = int(np.flatnonzero(~after.box.split.held)[1])
    scale = np.where(after.box.block == block, np.sqrt(5.0), 1.0)
    before = replace(after, residuals={NAME: scale * after.residuals[NAME]})
    assert share_mended(LIMIT, before, after) == pytest.approx(2.0)  # of five parts it takes away four
    assert share_mended(OFFSET, before, after) == 0.0
    assert mended_most(before, after)[0] == ""


def test_what_acts_throughout_counts_where_it_was_held_out() -> None:
    after = _after()
    before = replace(after, residuals={NAME: np.sqrt(2.0) * after.residuals[NAME]})
    assert share_mended(OFFSET, before, after) == pytest.approx(1.0)
    assert mended_most(before, after) == pytest.approx((NAME, 1.0, 1.0 - np.sqrt(0.5)))
