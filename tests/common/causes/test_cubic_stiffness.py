"""A spring that hardens or softens: the known backbone curve."""

import numpy as np
import pytest

from stillarm.common.files.model import Mode
from stillarm.common.user_error import UserError
from tests.fixtures.shaken_arm import CYCLE_S, arm, assert_acts_as, rings
from tests.reference.effects_judge import ringing


@pytest.mark.slow
@pytest.mark.parametrize("coefficient", [900.0, -600.0])
def test_the_force_is_the_catalogues(coefficient: float) -> None:
    assert_acts_as(
        {"cause": "cubic_stiffness", "coefficient_per_m2": coefficient},
        lambda t, w, q, v: -w * w * coefficient * q**3,
    )


def test_two_forces_at_once_are_still_of_second_order() -> None:
    """Their kicks mirror each other across the cycle; in one order both times, the error would be 17 times larger."""
    effects = (
        {"cause": "cubic_stiffness", "coefficient_per_m2": 900.0},
        {"cause": "quadratic_damping", "coefficient_per_m": 8.0},
    )
    times, found = rings(arm(*effects), 0.02, 250)
    wanted = ringing(0.02, times, force=lambda t, w, q, v: -w * w * 900.0 * q**3 - 8.0 * v * abs(v))
    assert np.max(np.abs(found - wanted)) < 1e-5 * 0.02


def test_cubic_stiffness_has_the_known_backbone_curve() -> None:
    """Duffing without damping: w / w1 = 1 + 3 c A^2 / 8 - 21 (c A^2)^2 / 256 + ... (Nayfeh and Mook)."""
    for amplitude in (0.005, 0.015, 0.025):
        plant = arm(
            {"cause": "cubic_stiffness", "coefficient_per_m2": 200.0},
            modes=[Mode(frequency_hz=2.6, damping_ratio=0.0)],
        )
        times, found = rings(plant, amplitude, 8000)
        greatest = float(np.max(found))
        up = np.flatnonzero((found[:-1] < 0.0) & (found[1:] >= 0.0))
        crossings = times[up] - found[up] * CYCLE_S / (found[up + 1] - found[up])
        period = float(np.mean(np.diff(crossings)))
        e = 200.0 * greatest**2
        assert 1.0 / period / 2.6 == pytest.approx(1.0 + 3.0 * e / 8.0 - 21.0 * e * e / 256.0, rel=1e-4)


def test_a_softening_arm_that_no_longer_returns_is_refused_in_one_line() -> None:
    plant = arm({"cause": "cubic_stiffness", "coefficient_per_m2": -2000.0})
    with pytest.raises(UserError, match=r"^effects: cubic_stiffness: coefficient_per_m2 = -2000: [^\n]+$"):
        rings(plant, 0.05, 1000)
