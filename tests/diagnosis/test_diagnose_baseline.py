"""The baseline's fit finds an arm whose frequency is far from the model's, and says nothing else of it."""

import pytest

from diagnosis.diagnose import _at_the_seen_frequency
from diagnosis.split import interleaved
from diagnosis.world import World
from tests.diagnosis.synthetic import MODEL, measured


@pytest.mark.parametrize("hz", [2.6, 3.1])
def test_a_frequency_far_off_is_fitted(hz: float) -> None:
    world = World(measured(20.0, 5, {"modes.0.frequency_hz": hz}), MODEL)
    found = _at_the_seen_frequency(world, interleaved(20.0))
    assert found.value("modes.0.frequency_hz") == pytest.approx(hz, rel=1e-3)
    assert found.value("modes.0.damping_ratio") == pytest.approx(MODEL.arm.modes[0].damping_ratio, rel=0.1)
