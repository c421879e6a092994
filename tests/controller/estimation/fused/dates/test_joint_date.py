"""The three dates of a frame: together better than the best of them, and none believed that follows something else."""

import numpy as np
import pytest

from stillarm.controller.estimation.fused.dates.joint_date import JointDate

FRAME_S = 1.0 / 65.0


def dated(
    arrival_s: float, started_s: float, numbered_s: float, *, count: int = 4000, started_at_zero: bool = False
) -> float:
    """Spread of arrival + correction about the exposure, which itself strays from its number; s."""
    random = np.random.default_rng(1)
    joint = JointDate()
    errors = []
    for k in range(count):
        number = FRAME_S * k
        exposed = number + numbered_s * random.standard_normal()
        arrival = exposed + arrival_s * random.standard_normal()
        started = 0.0 if started_at_zero else exposed - 0.008 + started_s * random.standard_normal()
        errors.append(arrival + joint.correction_s(started - arrival, number - arrival, 0.02) - exposed)
    return float(np.std(errors[count // 4 :]))


@pytest.mark.parametrize(
    ("arrival_s", "started_s", "numbered_s"),
    [(0.0064, 0.004, 0.0064), (0.0064, 0.004, 0.002), (0.002, 0.006, 0.006)],
)
def test_each_weighs_as_much_as_it_is_worth(arrival_s: float, started_s: float, numbered_s: float) -> None:
    """Within a tenth of what the true variances would give."""
    best = (arrival_s**-2 + started_s**-2 + numbered_s**-2) ** -0.5
    assert dated(arrival_s, started_s, numbered_s) < 1.1 * best


def test_an_n_i_that_tells_nothing_does_no_harm() -> None:
    """Always the same cycle."""
    assert dated(0.003, 0.0, 0.006, started_at_zero=True) < 0.0031


def test_a_wandering_number_is_followed() -> None:
    """Half a millisecond a frame, without bound."""
    random = np.random.default_rng(2)
    joint, base, errors = JointDate(), 0.0, []
    for _ in range(6000):
        base += FRAME_S + 0.0005 * random.standard_normal()
        exposed = base + 0.006 * random.standard_normal()
        arrival = exposed + 0.006 * random.standard_normal()
        started = exposed + 0.004 * random.standard_normal()
        errors.append(arrival + joint.correction_s(started - arrival, base - arrival, 0.06) - exposed)
    assert np.std(errors[1000:]) < 1.15 * (2 * 0.006**-2 + 0.004**-2) ** -0.5
