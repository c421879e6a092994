"""A displacement shows as d (1 + c d^2)."""

import numpy as np
import pytest

from tests.fixtures.seen_images import LENS, assert_rendered_as_stated, position, seen


def test_it_is_what_the_catalogue_says() -> None:
    """The motion is slow: its mean over 15 ms equals the value at mid-exposure within 1e-3 px."""
    mids, shown = seen(LENS)
    d = -800.0 * position(mids)
    assert shown == pytest.approx(d * (1.0 + 4e-5 * d * d), abs=0.01)
    assert np.max(np.abs(4e-5 * d**3)) > 2.0


@pytest.mark.slow
def test_rendered_and_tracked_images_show_the_same() -> None:
    assert_rendered_as_stated(LENS)
