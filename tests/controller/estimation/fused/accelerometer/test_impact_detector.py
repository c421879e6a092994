"""An impact by the blocks alone: found with size and onset, and not in noise."""

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from stillarm.controller.estimation.fused.accelerometer.blocks import Block
from stillarm.controller.estimation.fused.accelerometer.impact_detector import ImpactDetector

once = settings(max_examples=15, deadline=None, derandomize=True, phases=[Phase.explicit, Phase.generate])


@once
@given(
    size=st.floats(0.3, 3.0),
    onset=st.integers(2, 8),
    seed=st.integers(0, 50),
    sign=st.sampled_from((-1.0, 1.0)),
)
def test_an_impact_is_found_with_its_size_and_onset(size: float, onset: int, seed: int, sign: float) -> None:
    """Blocks of 16 ms with noise of a fortieth: within two blocks of its onset."""
    random = np.random.default_rng(seed)
    detector = ImpactDetector([16.3], 0.016)
    for k in range(20):
        after = (k - onset + 0.5) * 0.016
        value = 0.025 * random.standard_normal() + (sign * size * np.sin(16.3 * after) if after > 0 else 0.0)
        impact = detector.see(Block(0.016 * k, 0.016 * (k + 1), 16), value, 0.025**2, 1.0)
        if impact is not None:
            assert abs(k + 1 - impact.blocks_ago - onset) <= 2
            assert 0.3 * size < impact.sizes_m[0] < 3.0 * size
            return
    pytest.fail("the blow was not seen")


def test_noise_alone_is_no_impact() -> None:
    """Twenty seconds of it."""
    random = np.random.default_rng(3)
    detector = ImpactDetector([16.3], 0.016)
    found = [
        detector.see(Block(0.016 * k, 0.016 * (k + 1), 16), float(random.standard_normal()), 1.0, 10.0)
        for k in range(1250)
    ]
    assert all(impact is None for impact in found)
