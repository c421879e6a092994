"""Regression, change detection and the image's offset on exact and noisy decaying sines."""

from math import exp

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stillarm.controller.estimation.prediction.sine_regression import SineRegression
from tests.fixtures.decaying_vibration import MODE, A, W, vibration


@given(
    frames=st.integers(3, 20),
    phase=st.floats(0.0, 6.28),
    ahead_s=st.floats(0.0, 0.2),
    offset=st.floats(-0.1, 0.1),
)
def test_an_exact_sine_is_predicted_exactly(frames: int, phase: float, ahead_s: float, offset: float) -> None:
    """From three frames on, for any phase and any prediction horizon."""
    regression = SineRegression(MODE, frames, 1e-9, 0.0)
    for k in range(frames):
        regression.add(k / 65, vibration(k / 65, phase) + offset, offset, 0.25)
    t = (frames - 1) / 65 + ahead_s
    assert regression.predict(t).deflection_m == pytest.approx(vibration(t, phase), abs=1e-9)
    rate = (vibration(t + 1e-6, phase) - vibration(t - 1e-6, phase)) / 2e-6
    assert regression.predict(t).rate_m_s == pytest.approx(rate, abs=1e-6)


def test_the_stated_deviation_is_that_of_the_error() -> None:
    """White noise on the samples, a full window: normalised error squared near 1 over many trials."""
    random = np.random.default_rng(5)
    squares = []
    for _ in range(300):
        regression = SineRegression(MODE, 20, 1e-4, 0.0)
        for k in range(20):
            regression.add(k / 65, vibration(k / 65) + 1e-4 * random.standard_normal(), 0.0, 0.25)
        said = regression.predict(19 / 65 + 0.074)
        squares.append(((said.deflection_m - vibration(19 / 65 + 0.074)) / said.std_m) ** 2)
    assert 0.6 < np.mean(squares) < 1.4


def test_an_impact_cuts_the_window_and_noise_does_not() -> None:
    """The fit is right again five frames after an impact; a minute of noise does not cut the window."""
    random = np.random.default_rng(1)
    regression = SineRegression(MODE, 20, 5e-5, 0.0064)
    changes = 0
    for k in range(65 * 60):
        late = 0.0064 * random.standard_normal()
        changes += regression.add(
            k / 65 + late, vibration(k / 65, 0.0, A * exp(0.01 * W * k / 65)), 0.0, 0.25
        )
    assert changes <= 1
    regression = SineRegression(MODE, 20, 5e-5, 0.0064)
    for k in range(60):
        value = vibration(k / 65) if k < 40 else vibration(k / 65, 2.0, 2 * A)
        regression.add(k / 65, value, 0.0, 0.25)
        if k == 46:
            assert regression.samples <= 7
            assert regression.predict(46 / 65).deflection_m == pytest.approx(
                vibration(46 / 65, 2.0, 2 * A), abs=1e-6
            )


def test_a_long_gap_starts_afresh() -> None:
    """No fit across a gap: the phase is lost."""
    regression = SineRegression(MODE, 20, 1e-9, 0.0)
    for k in range(10):
        regression.add(k / 65, vibration(k / 65), 0.0, 0.25)
    regression.add(2.0, 0.0, 0.0, 0.25)
    assert regression.samples == 1


@given(
    times=st.lists(st.floats(0.0, 0.004), min_size=3, max_size=5),
    errors=st.lists(st.floats(-0.05, 0.05), min_size=5, max_size=5),
)
def test_samples_dated_almost_alike_do_not_make_it_explode(times: list[float], errors: list[float]) -> None:
    """Three to five frames within 4 ms, each 5 % of A off: 74 ms ahead the fit stays within some amplitudes."""
    regression = SineRegression(MODE, 20, 5e-5, 0.0064)
    for t, error in zip(times, errors, strict=False):
        regression.add(t, vibration(t) + error * A, 0.0, 0.25)
    assert abs(regression.predict(times[-1] + 0.074).deflection_m) < 3.0 * A
