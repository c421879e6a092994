"""The filter's parts against matrix exponentials and against conditioning one joint Gaussian law."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.controller.estimation.kalman.belief import (
    Belief,
    first_belief,
    predicted,
    seen_from,
    updated,
    updated_by_batch,
)
from stillarm.controller.estimation.kalman.kalman_method import quadratic_form
from stillarm.controller.estimation.kalman.two_time_scales import Densities, TwoTimeScales
from tests.fixtures.kalman_space import MODES, space


def image_row(model: TwoTimeScales) -> np.ndarray:
    row = np.zeros(model.size)
    row[[0, 2, model.slow]] = 1.0
    return row


def test_measurements_at_their_own_time_give_the_exact_posterior_of_the_present() -> None:
    """Twelve late images, then the present 80 ms later: equal to conditioning the joint law of all of them."""
    random = np.random.default_rng(4)
    model = space()
    times = 0.2 + np.cumsum(random.uniform(0.01, 0.03, 12))
    variances = random.uniform(1e-8, 1e-6, 12)
    values = 0.008 * np.cos(17.0 * times) + np.sqrt(variances) * random.standard_normal(12)
    belief = first_belief(model, 0.2, 0.003)
    prior = belief
    row = image_row(model)
    for t, value, variance in zip(times, values, variances, strict=True):
        belief = predicted(model, belief, t)
        belief = updated(model, belief, row, value, variance, None)
        assert not belief.outside_gate
    present = predicted(model, belief, times[-1] + 0.08)
    moments = [*times, times[-1] + 0.08]
    means = [model.transition(t - 0.2) @ prior.state for t in moments]

    def covariance(i: int, j: int) -> np.ndarray:
        early, late = sorted((moments[i], moments[j]))
        at = model.transition(early - 0.2)
        of_early = at @ prior.covariance @ at.T + model.scatter(early - 0.2)
        cross = model.transition(late - early) @ of_early
        return cross if moments[i] >= moments[j] else cross.T

    seen = np.array([[row @ covariance(i, j) @ row for j in range(12)] for i in range(12)]) + np.diag(
        variances
    )
    to_present = np.array([covariance(12, j) @ row for j in range(12)]).T
    gain = np.linalg.solve(seen, to_present.T).T
    expected = means[12] + gain @ (values - np.array([row @ mean for mean in means[:12]]))
    spread = covariance(12, 12) - gain @ to_present.T
    assert present.state == pytest.approx(expected, rel=1e-5, abs=1e-8)
    assert np.sqrt(np.diag(present.covariance)) == pytest.approx(np.sqrt(np.diag(spread)), rel=1e-4)


def test_a_batch_is_the_same_as_its_samples_one_by_one() -> None:
    """There are no disturbances between the samples; the beliefs are compared at their end."""
    random = np.random.default_rng(1)
    model = space(0.5)
    start = first_belief(model, 0.0, 0.0)
    rows = random.standard_normal((30, model.size)) * np.array([5.0, 0.3, 5.0, 0.05, 1.0, 0.5, 1.0])
    values = rows @ (0.02 * random.standard_normal(model.size)) + random.standard_normal(30)
    single = start
    for row, value in zip(rows, values, strict=True):
        single = updated(model, single, row, value, 1.0, None)
        assert not single.outside_gate
    batch = updated_by_batch(model, start, rows, values, 0.03)
    assert not batch.outside_gate
    assert batch.state == pytest.approx(single.state, abs=1e-9)
    assert batch.covariance == pytest.approx(single.covariance, abs=1e-10)


def test_neighbours_that_change_places_are_both_used() -> None:
    """Without disturbances the order of two samples makes no difference."""
    model = TwoTimeScales(MODES, Densities(0.0, 0.0, 0.0), None)
    row, start = image_row(model), first_belief(model, 0.0, 0.0)

    def taken(*samples: tuple[float, float]) -> Belief:
        belief = start
        for t, value in samples:
            belief = predicted(model, belief, t)
            seen = seen_from(model, belief, row, t)
            belief = updated(model, belief, seen, value, 1e-6, None)
        return predicted(model, belief, 0.1)

    one, other = taken((0.02, 0.004), (0.025, 0.005)), taken((0.025, 0.005), (0.02, 0.004))
    assert one.state == pytest.approx(other.state, abs=1e-10)
    assert one.covariance == pytest.approx(other.covariance, abs=1e-9)


def test_a_measurement_outside_the_gate_is_skipped_once_and_then_an_impact() -> None:
    """The modes' covariance grows enough to explain it; the covariance of the image's zero does not change."""
    model = space()
    row, belief = image_row(model), first_belief(model, 0.0, 0.0)
    for k in range(1, 60):
        belief = updated(model, predicted(model, belief, k / 65), row, 0.0, 1e-8, None)
    belief = predicted(model, belief, 60 / 65)
    left_out = updated(model, belief, row, 0.01, 1e-8, None)
    assert left_out.outside_gate and np.array_equal(left_out.state, belief.state)
    struck = updated(model, belief, row, 0.01, 1e-8, 1 / 65)
    assert struck.outside_gate
    assert float(row @ struck.state) == pytest.approx(0.01, rel=0.01)
    assert abs(struck.state[model.slow]) < 0.03 * 0.01
    assert struck.covariance[1, 1] > 100.0 * belief.covariance[1, 1]
    assert struck.covariance[4, 4] <= 1.001 * belief.covariance[4, 4]


@given(seed=st.integers(0, 1000), size=st.integers(1, 8))
@settings(max_examples=30, derandomize=True)
def test_the_quadratic_form_is_numpys(seed: int, size: int) -> None:
    """row @ matrix @ row."""
    random = np.random.default_rng(seed)
    half, row = random.standard_normal((size, size)), random.standard_normal(size)
    matrix = half @ half.T
    assert quadratic_form(matrix.tolist(), row.tolist()) == pytest.approx(float(row @ matrix @ row))
