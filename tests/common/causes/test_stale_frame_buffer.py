"""An older image under the new number and stamp."""

import numpy as np
import pytest

from tests.fixtures.exposures import ORIGIN_S, column, exposures


def test_a_stale_buffer_hands_over_an_older_image_under_the_new_number_and_stamp() -> None:
    effect = {"cause": "stale_frame_buffer", "onset_s": 4.0, "frames": 2}
    plain, stale = exposures(frames=600, stamped=True), exposures(effect, frames=600, stamped=True)
    for name in ("frame", "handover_s", "stamp_s", "readout_end_s"):
        assert np.array_equal(column(stale, name), column(plain, name))
    age = column(plain, "mid_s") - column(stale, "mid_s")
    after = column(plain, "start_s") - ORIGIN_S >= 4.0
    assert np.all(age[~after] == 0.0)
    assert age[after] == pytest.approx(np.full(np.sum(after), 2.0 / 65.0), abs=1e-9)
    assert column(plain, "start_s") - column(stale, "start_s") == pytest.approx(age, abs=1e-9)
