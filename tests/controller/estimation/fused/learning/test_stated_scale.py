"""The model's image scale weighed against the sensors: odds, mixture, and what the fused method gains by it."""

import numpy as np
import pytest

from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.model import Accelerometer, Commissioned, Model
from stillarm.controller.estimation.fused import present
from stillarm.controller.estimation.fused.learning.stated_scale import (
    Stated,
    odds_as_stated,
    stated_scale,
    with_stated_scale,
)
from stillarm.controller.estimation.fused.method import FusedMethod
from tests.reference.ringing_world import judge, model_for, ring

AMPLITUDE = 0.006
FIRST, STATED = 0.07**2, 0.005**2
EVEN = Stated(STATED, 1.0)
SCALE = 1


def told(error: float, std: float, odds: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """A state (vibration, scale) of which the filters say `error` +- std of the scale, and what is told of it."""
    across = -0.8 * std**2
    p = np.array([[std**2, across], [across, std**2]])
    return with_stated_scale(np.array([0.0, error]), p, SCALE, FIRST, Stated(STATED, odds))


def brute_force(error: float, std: float, odds: float) -> tuple[float, float]:
    """Mean and variance of the scale's error by integration over it, with the mixture as its prior."""
    e = np.linspace(-0.4, 0.4, 400001)

    def normal(at: np.ndarray | float, variance: float) -> np.ndarray:
        return np.asarray(np.exp(-0.5 * np.square(at) / variance) / np.sqrt(variance))

    own = 1.0 / (1.0 / std**2 - 1.0 / FIRST)
    density = normal(e - error * own / std**2, own) * (normal(e, FIRST) + odds * normal(e, STATED))
    density /= density.sum()
    mean = float(density @ e)
    return mean, float(density @ (e - mean) ** 2)


@pytest.mark.parametrize("error", [0.0, 0.004, -0.02, 0.05])
@pytest.mark.parametrize("std", [0.004, 0.01, 0.03])
@pytest.mark.parametrize("odds", [1.0, 9.0])
def test_the_mixture_is_that_of_the_integral(error: float, std: float, odds: float) -> None:
    """Mean and variance of the scale under its prior of two normal distributions."""
    x, p = told(error, std, odds)
    mean, variance = brute_force(error, std, odds)
    assert x[SCALE] == pytest.approx(mean, abs=1e-6)
    assert p[SCALE, SCALE] == pytest.approx(variance, rel=1e-3)


def test_what_hangs_together_with_the_scale_gains_as_well() -> None:
    """The vibration's amplitude, known only as well as the scale."""
    x, p = told(0.005, 0.009)
    assert 0.0 < x[0] < 0.005
    assert p[0, 0] < 0.8 * 0.009**2
    assert np.linalg.eigvalsh(p).min() > 0.0
    assert np.allclose(p, p.T)


def test_another_scene_overrules_the_model() -> None:
    """20 % off, seen to 1 %: nothing is left of what the model says."""
    assert odds_as_stated(0.2, 0.01**2, FIRST, EVEN) < 1e-20
    x, p = told(0.2, 0.01)
    assert x[SCALE] == pytest.approx(0.2, rel=1e-9)
    assert p[SCALE, SCALE] == pytest.approx(0.01**2, rel=1e-9)


def test_nothing_is_judged_before_the_sensors_have_spoken_nor_long_after() -> None:
    """The state comes back as it is."""
    for std in (0.07, 0.0009):
        x, p = told(0.001, std)
        assert x[SCALE] == 0.001
        assert p[SCALE, SCALE] == std**2


def test_what_is_told_leaves_the_filter_alone() -> None:
    """It is told anew after each image: the filter's own arrays do not change."""
    x, p = np.array([0.0, 0.004]), np.diag([1e-4, 1e-4])
    with_stated_scale(x, p, SCALE, FIRST, EVEN)
    assert x.tolist() == [0.0, 0.004]
    assert p.tolist() == np.diag([1e-4, 1e-4]).tolist()


def commissioned(**std: float) -> Model:
    """A model with scales of 800 px/m and -1, and these deviations of them."""
    known = {name.replace("__", "."): value for name, value in std.items()}
    return Model(
        accelerometer=Accelerometer(scale=-1.0), commissioned=Commissioned("2026-01-01", "arm.mcap", known)
    )


def test_a_commissioned_model_says_how_well_its_scales_are_known() -> None:
    """Of both together, as the images' scale counts relative to the accelerometer's; never better than the scene."""
    told = commissioned(camera__scale_px_per_m=2.4, accelerometer__scale=0.004)
    assert stated_scale(told, FIRST) == pytest.approx((0.005**2, 9.0))
    exact = commissioned(camera__scale_px_per_m=0.1, accelerometer__scale=0.0001)
    assert stated_scale(exact, FIRST) == pytest.approx((0.002**2, 9.0))
    for silent in (Model(), commissioned(camera__scale_px_per_m=2.4)):
        assert stated_scale(silent, FIRST) == pytest.approx((STATED, 1.0))


def early_error(seed: int, scale_factor: float) -> float:
    """Of the fused method from 1 to 3 s, rms, as a share of the amplitude."""
    model = model_for(AMPLITUDE, 0.3)
    trial = judge(
        FusedMethod(model, Settings().fused, "model"),
        model,
        ring(model, seed, 3.0, delay="drift", scale_factor=lambda t: scale_factor),
    )
    return float(np.sqrt(np.mean(np.square(trial.error[1000:]))))


@pytest.mark.slow
def test_the_first_seconds_gain_where_the_model_is_right_and_lose_little_where_it_is_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Beside the filters alone, four trials: scale as stated, and 20 % off."""
    weighed = [[early_error(seed, scale) for seed in range(4)] for scale in (1.0, 1.2)]
    monkeypatch.setattr(present, "with_stated_scale", lambda x, p, scale, first, stated, assumed: (x, p))
    alone = [[early_error(seed, scale) for seed in range(4)] for scale in (1.0, 1.2)]
    assert np.mean(weighed[0]) < 0.95 * np.mean(alone[0])
    assert np.mean(weighed[1]) < 1.01 * np.mean(alone[1])
