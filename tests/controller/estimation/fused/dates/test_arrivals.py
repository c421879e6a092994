"""White spread and wander of arrivals, from their differences."""

import numpy as np
import pytest

from stillarm.controller.estimation.fused.dates.arrivals import ArrivalSpread

FRAME_S = 1.0 / 65.0


@pytest.mark.parametrize(("white_s", "walk"), [(0.002, 0.0), (0.0004, 2e-6), (0.0, 0.0)])
def test_white_spread_and_wander_of_arrivals_are_told_apart(white_s: float, walk: float) -> None:
    """The structure function gives both back within a factor of two and a half; steady arrivals are steady."""
    random = np.random.default_rng(4)
    spread = ArrivalSpread(FRAME_S, 0.0064, 0.001)
    level = 0.0
    for _ in range(4000):
        level += np.sqrt(walk * FRAME_S) * random.standard_normal()
        spread.add(float(level + white_s * random.standard_normal()))
    white = max(white_s**2 + 0.5 * walk * FRAME_S, 0.001**2 / 12)
    assert 0.7 * white < spread.white < 1.4 * white
    if walk:
        assert 0.6 * walk < spread.walk < 3.5 * walk
    else:
        assert spread.walk < 1e-6


def test_no_walk_is_seen_in_white_noise_nor_before_enough_is_known() -> None:
    """White noise of 6.4 ms: a wander below a twentieth of it in a square root second is believed after 40 s."""
    random = np.random.default_rng(6)
    for _ in range(5):
        spread = ArrivalSpread(FRAME_S, 0.0064, 0.001)
        for count in range(2600):
            assert spread.known == (count >= 256 + 512)
            spread.add(float(0.0064 * random.standard_normal()))
        assert spread.walk < (0.05 * 0.0064) ** 2
