"""The same numbers as with the mode in [[arm.modes]]."""

import numpy as np

from stillarm.common.files.model import Mode
from tests.fixtures.shaken_arm import arm


def test_a_second_bending_mode_is_one_of_the_arms() -> None:
    """The same numbers as with the mode in [[arm.modes]]."""
    second = {"frequency_hz": 15.0, "damping_ratio": 0.02, "participation": -0.2}
    first = Mode()
    named, listed = arm({"cause": "second_bending_mode", **second}), arm(modes=[first, Mode(**second)])
    for command in np.random.default_rng(0).uniform(-0.3, 0.3, 300).tolist():
        named.advance(command)
        listed.advance(command)
    assert named.modal_deflections_m == listed.modal_deflections_m
    assert named.tip_acceleration_m_s2 == listed.tip_acceleration_m_s2
