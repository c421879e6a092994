"""What is taken from a recording of a driven joint."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.diagnosis.driven.recording.signals import Driven, Output, counter_step, thinned


@settings(deadline=None, max_examples=40)
@given(st.floats(1e-6, 10.0), st.integers(0, 1000))
def test_an_encoders_step_is_found_and_noise_has_none(step: float, seed: int) -> None:
    generator = np.random.default_rng(seed)
    angle = 40.0 * step * np.sin(np.arange(2000) / 70.0) + generator.uniform()
    assert counter_step(np.rint(angle / step) * step) == pytest.approx(step, rel=1e-6)
    assert counter_step(angle + step * generator.standard_normal(2000)) == 0.0


def test_thinned_keeps_the_inputs_impulse() -> None:
    """The mean of the samples left out: what an input gave to a joint over them."""
    u = np.arange(1001.0)
    output = Output("joint_position_rad", "position", u.copy(), True, 0.0)
    driven = Driven("x", 0.001, 0.0, "motor_current_a", u, True, (output,), {})
    less = thinned(driven, 4)
    assert less.step_s == pytest.approx(0.004)
    assert less.u.sum() * less.step_s == pytest.approx(u[:1000].sum() * 0.001)
    assert np.array_equal(less.outputs[0].values, u[:1000:4])
