"""The displacement moves evenly."""

import pytest

from tests.fixtures.seen_images import DRIFT, assert_rendered_as_stated, position, seen


def test_it_is_what_the_catalogue_says() -> None:
    """The motion is slow: its mean over 15 ms equals the value at mid-exposure within 1e-3 px."""
    mids, shown = seen(DRIFT)
    d = -800.0 * position(mids)
    assert shown == pytest.approx(d + 3.0 * mids, abs=0.01)


@pytest.mark.slow
def test_rendered_and_tracked_images_show_the_same() -> None:
    assert_rendered_as_stated(DRIFT)
