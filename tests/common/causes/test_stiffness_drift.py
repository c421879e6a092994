"""The frequency moves evenly."""

import numpy as np
import pytest

from stillarm.common.user_error import UserError
from tests.fixtures.shaken_arm import arm, rings
from tests.reference.effects_judge import ringing


def test_a_drifting_stiffness_moves_the_frequency_evenly() -> None:
    effect = {"cause": "stiffness_drift", "frequency_rate_hz_per_s": 0.05}
    times, found = rings(arm(effect), 0.006, 6000)
    wanted = ringing(0.006, times, frequency_hz=lambda t: 2.6 + 0.05 * t)
    assert np.max(np.abs(found - wanted)) < 1e-4 * 0.006
    down = arm({"cause": "stiffness_drift", "frequency_rate_hz_per_s": -2.0})
    with pytest.raises(UserError, match=r"^effects: stiffness_drift: at 1\.\d+ s [^\n]+$"):
        rings(down, 0.001, 2000)
