"""The uniform beam."""

from math import cos, cosh, pi, sin, sinh

import pytest
from scipy.optimize import brentq

from stillarm.common.files.beam import tip_slopes_per_m


def test_tip_slopes_are_those_of_a_cantilever() -> None:
    for number, slope in enumerate(tip_slopes_per_m(1.0, 8), 1):
        near = (number - 0.5) * pi
        k = brentq(lambda x: cos(x) + 1.0 / cosh(x), near - 0.4, near + 0.4, xtol=1e-14)
        sigma = (cosh(k) + cos(k)) / (sinh(k) + sin(k))
        shape = cosh(k) - cos(k) - sigma * (sinh(k) - sin(k))
        exact = k * (sinh(k) + sin(k) - sigma * (cosh(k) - cos(k))) / shape
        assert slope == pytest.approx(exact, rel=1e-6)
    assert tip_slopes_per_m(2.0, 1)[0] == pytest.approx(tip_slopes_per_m(1.0, 1)[0] / 2.0)
