"""The exact form: the frequency found where the samples show it, the model's kept where they do not."""

from math import cos, exp, hypot, pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.configuration import Regression
from stillarm.common.files.model import Arm, Mode, Model
from stillarm.controller.estimation.estimate import Status
from stillarm.controller.estimation.prediction.exact_regression import ExactRegression
from stillarm.controller.estimation.prediction.sine_regression import SineRegression
from stillarm.controller.loop.step import Controller
from tests.reference.arm_world import constant, run_world

MODE = Mode(frequency_hz=2.6, damping_ratio=0.01)
A = 0.006


def vibration(t: float, frequency_hz: float, phase: float = 0.0) -> float:
    w = 2 * pi * frequency_hz
    return A * exp(-0.01 * w * t) * cos(w * sqrt(1 - 1e-4) * t + phase)


def regression(noise_m: float, dating_s: float = 0.0, frames: int = 20, exact: bool = True) -> SineRegression:
    form = ExactRegression(MODE, noise_m, dating_s, 0.05) if exact else None
    return SineRegression(MODE, frames, noise_m, dating_s, exact=form)


@given(
    factor=st.floats(0.92, 1.08),
    phase=st.floats(0.0, 6.28),
    frames=st.integers(8, 20),
    ahead_s=st.floats(0.0, 0.1),
)
@settings(max_examples=60, derandomize=True)
def test_without_noise_the_frequency_and_the_future_are_found(
    factor: float, phase: float, frames: int, ahead_s: float
) -> None:
    """8 % off the model's, from eight frames (a third of a period) on: frequency to 0.5 %, prediction to 0.6 %."""
    fit = ExactRegression(MODE, 1e-6, 0.0, 0.05)
    t = np.arange(1 - frames, 1) / 65
    values = np.array([vibration(x, 2.6 * factor, phase) for x in t])
    assert fit.fit(t, values).angular_frequency == pytest.approx(2 * pi * 2.6 * factor, rel=0.005)
    whole = regression(1e-6, frames=frames)
    for x, value in zip(t, values, strict=True):
        whole.add(float(x), float(value), 0.0, 0.25)
    said = whole.predict(ahead_s).deflection_m
    assert said == pytest.approx(vibration(ahead_s, 2.6 * factor, phase), abs=0.006 * A)


def test_it_predicts_better_than_the_simplified_form_when_the_model_is_off() -> None:
    """4 % off, image noise of 1 % of the amplitude: the simplified form errs by several per cent."""
    random = np.random.default_rng(3)
    errors: dict[bool, list[float]] = {True: [], False: []}
    for _ in range(60):
        phase = random.uniform(0, 2 * pi)
        noise = 6e-5 * random.standard_normal(20)
        for exact, found in errors.items():
            fitted = regression(6e-5, exact=exact)
            for k in range(20):
                fitted.add(k / 65, vibration(k / 65, 2.6 * 1.04, phase) + noise[k], 0.0, 0.25)
            ahead = 19 / 65 + 0.074
            found.append(fitted.predict(ahead).deflection_m - vibration(ahead, 2.6 * 1.04, phase))
    assert np.std(errors[True]) < 0.6 * np.std(errors[False])
    assert np.std(errors[False]) > 0.03 * A


@pytest.mark.slow
def test_the_stated_deviation_is_that_of_the_error() -> None:
    """A frequency drawn from the prior, white noise: normalised error squared near 1, for long and short windows."""
    random = np.random.default_rng(6)
    for frames in (20, 10, 6):
        squares = []
        for _ in range(400):
            frequency, phase = 2.6 * (1 + 0.05 * random.standard_normal()), random.uniform(0, 2 * pi)
            fitted = regression(6e-5, frames=frames)
            for k in range(frames):
                seen = vibration(k / 65, frequency, phase) + 6e-5 * random.standard_normal()
                fitted.add(k / 65, seen, 0.0, 0.25)
            ahead = (frames - 1) / 65 + 0.074
            said = fitted.predict(ahead)
            squares.append(((said.deflection_m - vibration(ahead, frequency, phase)) / said.std_m) ** 2)
        assert 0.6 < np.mean(squares) < 1.6


@given(
    times=st.lists(st.floats(-0.3, 0.0), min_size=2, max_size=19),
    scale=st.floats(1e-9, 1.0),
    seed=st.integers(0, 1000),
)
@settings(max_examples=80, derandomize=True)
def test_any_samples_give_finite_numbers_within_the_prior(
    times: list[float], scale: float, seed: int
) -> None:
    """Coinciding times, noise alone, zeros: the frequency stays within three deviations, all is finite."""
    t = np.array([*times, 0.0])
    values = scale * np.random.default_rng(seed).standard_normal(len(t))
    for y in (values, np.zeros(len(t))):
        fit = ExactRegression(MODE, 1e-5, 0.0064, 0.05).fit(t, y)
        assert abs(fit.angular_frequency / MODE.angular_frequency - 1.0) <= 0.15 + 1e-9
        assert np.all(np.isfinite([fit.a, fit.b, *fit.covariance, fit.a_per_w, fit.b_per_w]))
        assert 0.0 < fit.angular_frequency_variance <= (0.05 * MODE.angular_frequency) ** 2 * (1 + 1e-9)


def test_noise_alone_leaves_the_models_frequency() -> None:
    """Ill-conditioned: nothing in the samples tells a frequency, so the prior decides."""
    random = np.random.default_rng(2)
    t = np.arange(-19, 1) / 65
    fits = [
        ExactRegression(MODE, 6e-5, 0.0, 0.05).fit(t, 6e-5 * random.standard_normal(20)) for _ in range(40)
    ]
    off = np.array([fit.angular_frequency / MODE.angular_frequency - 1.0 for fit in fits])
    assert np.std(off) < 0.03
    assert max(hypot(fit.a, fit.b) for fit in fits) < 3 * 6e-5


@pytest.mark.slow
@pytest.mark.parametrize("method", ["timestamps", "correlation"])
def test_both_delays_work_with_the_exact_form(method: str) -> None:
    """The arm 3 % faster than the model: the exact form's error is smaller than the simplified one's."""
    model = Model(arm=Arm(length_m=2.0))
    errors = {}
    for form in ("simplified", "exact"):
        settings = Settings(arm_at_start=True, method=method, regression=Regression(form=form))  # type: ignore[arg-type]
        trace = run_world(
            model, Controller(model, settings), 4.0, strikes={0.2: 0.00625}, delay=constant(0.074),
            image_noise_px=0.05, frequency_factor=1.03,
        )  # fmt: skip
        assert trace.outputs[-1].estimate.status is Status.ESTIMATED
        a = trace.arrays()
        late = a["time"] > 2.0
        errors[form] = np.mean(np.abs(a["estimate"] - a["truth"])[late]) / 0.00625
    assert errors["exact"] < 0.8 * errors["simplified"]


def test_a_fixed_window_keeps_the_old_vibration_after_an_impact() -> None:
    """variable_window = false: no cut, so that the fit errs until the window has passed; switched on, it is cut."""
    held = {}
    for variable in (True, False):
        fitted = SineRegression(MODE, 20, 5e-5, 0.0, variable_window=variable)
        changed = False
        for k in range(46):
            value = vibration(k / 65, 2.6) if k < 40 else 2 * vibration(k / 65, 2.6, 2.0)
            changed |= fitted.add(k / 65, value, 0.0, 0.25)
        assert changed is variable
        held[variable] = abs(fitted.predict(45 / 65).deflection_m - 2 * vibration(45 / 65, 2.6, 2.0))
        assert fitted.samples == (6 if variable else 20)
    assert held[True] < 1e-6
    assert held[False] > 0.2 * A
