"""The image's zero, under a vibration and through silence."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.controller.estimation.prediction.image_offset import ImageOffset
from tests.fixtures.decaying_vibration import MODE, A, vibration


@given(offset=st.floats(-1.0, 1.0), phase=st.floats(0.0, 6.28))
@settings(max_examples=30)
def test_the_offset_is_found_under_a_vibration(offset: float, phase: float) -> None:
    """Within one period, to a hundredth of the amplitude; an impact does not move it."""
    found = ImageOffset(MODE, 3.0)
    for k in range(200):
        if k == 100:
            found.forget_vibration()
        value = vibration(k / 65, phase) if k < 100 else vibration(k / 65, phase + 2.0, 3 * A)
        found.add(k / 65, value + offset)
        if k > 25:
            assert found.offset_m == pytest.approx(offset, abs=0.01 * A + 1e-5 * abs(offset))


def test_the_offset_survives_a_long_silence() -> None:
    """Its covariance stays finite and positive during any silence."""
    found = ImageOffset(MODE, 3.0)
    for k in range(50):
        found.add(k / 65, 0.2)
    found.add(1e5, 0.3)
    for k in range(100):
        found.add(1e5 + k / 65, 0.3)
    assert found.offset_m == pytest.approx(0.3, abs=1e-3)
