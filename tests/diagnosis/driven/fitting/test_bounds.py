"""Sizes that no rig has, and those that only look odd."""

import numpy as np
import pytest

from stillarm.diagnosis.driven.fitting.bounds import LONGEST_DELAY_S, believable, within
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.recording.signals import Driven


@pytest.mark.parametrize(
    ("names", "numbers", "is_so"),
    [
        (("gap", "share"), {"gap": 0.01, "share": 0.3}, True),
        (("gap", "share"), {"gap": 0.05, "share": 0.0201}, False),  # a motor without inertia
        (("inertia_excess",), {"inertia_excess": 1.5}, True),
        (("inertia_excess",), {"inertia_excess": 9.9}, False),
        (("delay strain",), {"delay strain": 0.02}, True),
        (("delay strain",), {"delay strain": -0.0001}, False),  # a hundredth of a sample
        (("lag strain",), {"lag strain": 0.0004}, False),
        (("delay", "late"), {"delay": LONGEST_DELAY_S, "late": 1.0}, False),
        (("inertia_excess @1",), {"inertia_excess @1": -0.8}, False),
        (("coulomb", "stribeck"), {"coulomb": 1.0, "stribeck": 0.2}, True),
        (("coulomb", "stribeck"), {"coulomb": 1.0, "stribeck": 0.01}, False),  # how friction turns over
        (("coulomb @1", "stribeck @1"), {"coulomb": 1.0, "coulomb @1": 0.1, "stribeck @1": 0.02}, True),
        (("coulomb",), {"coulomb": 1e6}, True),  # no bound is known: the data decide
    ],
)
def test_a_size_at_a_bound_is_not_believed(
    names: tuple[str, ...], numbers: dict[str, float], is_so: bool
) -> None:
    assert believable(names, numbers, 0.01) is is_so


def test_a_stated_mode_stays_near_what_is_stated() -> None:
    """One that may go anywhere makes up for friction, far below the arm's frequency."""
    box = GreyBox(Driven("x", 0.01, 0.0, "motor_voltage_v", np.zeros(1000), True, (), {}), irregular(10.0))
    free = within({"log_w_1": -0.3}, box)
    stated = within({"log_w_1": -0.3, "stated_log_w_1": 2.7, "log_w_2": 4.0, "stated_log_w_2": 4.2}, box)
    assert free["log_w_1"] == -0.3
    assert stated["log_w_1"] == pytest.approx(2.0) and stated["log_w_2"] == 4.0
