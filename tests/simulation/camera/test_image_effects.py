"""The image's effects together, and those of no size."""

import numpy as np
import pytest

from tests.fixtures.seen_images import DRIFT, LENS, position, seen


def test_two_effects_add_up() -> None:
    """Of a slow motion, whose mean over 15 ms is that at mid-exposure within 1e-3 of a pixel."""
    mids, plain = seen()
    d = -800.0 * position(mids)
    assert plain == pytest.approx(d, abs=0.01)
    assert seen(LENS, DRIFT)[1] == pytest.approx(d * (1.0 + 4e-5 * d * d) + 3.0 * mids, abs=0.01)


def test_no_size_no_effect_to_the_bit() -> None:
    none = ({**LENS, "coefficient_per_px2": 0.0}, {**DRIFT, "rate_px_per_s": 0.0})
    assert np.array_equal(seen(*none)[1], seen()[1])
    assert np.array_equal(seen(LENS, still=True)[1], np.zeros(len(seen(still=True)[1])))
