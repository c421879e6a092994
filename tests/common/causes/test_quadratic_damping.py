"""Damping with the square of the rate: the force is the catalogue's."""

import pytest

from tests.fixtures.shaken_arm import assert_acts_as


@pytest.mark.slow
def test_the_force_is_the_catalogues() -> None:
    assert_acts_as(
        {"cause": "quadratic_damping", "coefficient_per_m": 8.0}, lambda t, w, q, v: -8.0 * v * abs(v)
    )
