"""The quadratic form against the same in arrays."""

import numpy as np
import pytest

from stillarm.controller.estimation.fused.small_arrays import quadratic_form


def test_it_is_the_variance_of_a_weighted_sum() -> None:
    random = np.random.default_rng(3)
    row, root = random.normal(size=4), random.normal(size=(4, 4))
    assert quadratic_form(row.tolist(), (root @ root.T).tolist()) == pytest.approx(
        np.sum((root.T @ row) ** 2)
    )
