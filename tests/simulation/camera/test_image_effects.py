"""The image's effects together, and those of no size."""

import numpy as np
import pytest

from tests.fixtures.seen_images import DRIFT, LENS, position, seen


def test_two_effects_add_up() -> None:
    """The motion is slow: its mean over 15 ms equals the value at mid-exposure within 1e-3 px."""
    mids, plain = seen()
    d = -800.0 * position(mids)
    assert plain == pytest.approx(d, abs=0.01)
    assert seen(LENS, DRIFT)[1] == pytest.approx(d * (1.0 + 4e-5 * d * d) + 3.0 * mids, abs=0.01)


def test_no_size_no_effect_to_the_bit() -> None:
    none = ({**LENS, "coefficient_per_px2": 0.0}, {**DRIFT, "rate_px_per_s": 0.0})
    assert np.array_equal(seen(*none)[1], seen()[1])
    assert np.array_equal(seen(LENS, still=True)[1], np.zeros(len(seen(still=True)[1])))
