"""Frames lost independently, in their share."""

import numpy as np
import pytest

from tests.fixtures.exposures import column, exposures


@pytest.mark.slow
def test_drops_take_their_share_independently_and_the_counter_goes_on() -> None:
    rows = exposures({"cause": "frame_drops", "fraction": 0.2}, frames=20_000)
    lost = column(rows, "lost")
    assert [row.frame for row in rows] == list(range(20_000))
    assert np.mean(lost) == pytest.approx(0.2, abs=4.0 * (0.16 / 20_000) ** 0.5)
    assert abs(np.corrcoef(lost[1:], lost[:-1])[0, 1]) < 0.03
    assert [row._replace(lost=False) for row in rows] == exposures(frames=20_000)
