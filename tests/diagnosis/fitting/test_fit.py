"""A fit finds what the data were made with, and its standard deviations are those of its errors."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.data.noise import log_likelihood
from stillarm.diagnosis.data.split import Split, interleaved
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import make_data
from stillarm.diagnosis.physics.computing import limited
from stillarm.diagnosis.physics.world import World
from tests.fixtures.synthetic import MODEL, fitted, measured

TRUE = {
    "modes.0.frequency_hz": 2.5,
    "modes.0.damping_ratio": 0.013,
    "modes.0.participation": 1.2,
    "accelerometer.bias_m_s2": 0.1,
    "camera.scale_px_per_m": 790.0,
    "timing.capture_delay_s": 0.08,
    "drive.bandwidth_hz": 12.0,
}
EXTRA = ("drive.bandwidth_hz",)


@pytest.mark.slow
def test_errors_are_as_large_as_their_standard_deviations_say() -> None:
    scores = []
    for seed in range(10):
        found = fitted(measured(6.0, seed, TRUE), *EXTRA)
        scores.append([(found.value(name) - true) / found.std[name] for name, true in TRUE.items()])
    errors = np.array(scores)
    assert np.all(np.abs(errors) < 5.0)
    # 70 squares of a standard normal: their mean lies within these but for one case in a thousand
    assert 0.5 < np.mean(errors**2) < 1.7, np.round(np.mean(errors**2, axis=0), 2)


@pytest.mark.slow
def test_what_is_held_out_is_not_fitted() -> None:
    data = measured(6.0, 1, TRUE)
    world = World(data, MODEL)
    split = Split(np.array([0.0, 2.0, 4.0, 6.0]), np.array([False, True, False]))
    spoilt = np.where(
        (world.cycle_times > 2.0) & (world.cycle_times < 4.0), data.acceleration + 5.0, data.acceleration
    )
    other = World(replace(data, acceleration=spoilt), MODEL)
    free = world.baseline_names()
    first = fit(make_data(world, split), world.space.vector(), free)
    second = fit(make_data(other, split), other.space.vector(), free)
    assert second.vector == pytest.approx(first.vector, rel=1e-9, abs=1e-12)
    assert second.held_out_score[1] < first.held_out_score[1] - 100.0


def test_missing_samples_are_no_samples() -> None:
    data = measured(6.0, 2, TRUE)
    holes = data.acceleration.copy()
    holes[1000:2500] = np.nan
    found = fitted(data.__class__(**{**data.__dict__, "acceleration": holes}))
    assert found.value("modes.0.frequency_hz") == pytest.approx(2.5, rel=1e-3)
    assert np.isnan(found.residuals["acceleration"][1000:2500]).all()


def test_derivatives_that_are_kept_lead_to_the_same_fit() -> None:
    data = measured(6.0, 5, {"modes.0.frequency_hz": 2.605})
    world = World(data, MODEL)
    given = make_data(world, interleaved(6.0))
    exact = fit(given, world.space.vector(), world.baseline_names())
    kept = fit(given, world.space.vector(), world.baseline_names(), iterations=30, anew=2)
    assert kept.train_log_likelihood == pytest.approx(exact.train_log_likelihood, abs=0.5)
    assert kept.value("modes.0.frequency_hz") == pytest.approx(exact.value("modes.0.frequency_hz"), rel=1e-5)


def test_no_level_of_the_noise_makes_a_fit_likelier() -> None:
    """Two fits are held against each other by their log-likelihoods: at a robust level one that leaves much in a part
    of the recording would seem the better, the wider its level."""
    data = measured(9.0, 3)
    loud = np.where(np.arange(data.cycles) % 3000 < 200, 3.0, 0.0) * np.sin(np.arange(data.cycles))
    found = fitted(replace(data, acceleration=data.acceleration + loud))
    marked = make_data(found.world, interleaved(9.0))
    best = 0.0
    for name, residual in found.residuals.items():
        trained = residual[marked.train[name]]
        levels = found.sigma[name] * np.geomspace(0.9, 5.0, 120)
        best += max(float(np.sum(log_likelihood(trained / one, one))) for one in levels)
    assert found.train_log_likelihood == pytest.approx(best, abs=2.0)


def test_a_motion_that_was_forgotten_is_worked_out_anew_whatever_time_is_left() -> None:
    found = fitted(measured(6.0, 2, TRUE))
    known = found.predicted.motion
    found.predicted.forget()
    assert found.predicted.moved is None
    with limited(0.0, lambda: 1.0):
        again = found.predicted.motion
    assert again is not known and again is found.predicted.motion
    for one in ("joint", "q", "tip", "tip_acceleration"):
        # a sum of the baseline's motion and of what impacts add rounds otherwise
        assert getattr(again, one) == pytest.approx(getattr(known, one), rel=1e-9, abs=1e-12)
