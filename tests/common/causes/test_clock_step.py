"""The camera's clock steps alone."""

import numpy as np
import pytest

from tests.fixtures.exposures import ORIGIN_S, column, exposures


def test_the_cameras_clock_steps_alone() -> None:
    effect = {"cause": "clock_step", "onset_s": 4.0, "step_s": -0.13, "clock": "camera"}
    plain, stepped = exposures(frames=600, stamped=True), exposures(effect, frames=600, stamped=True)
    jump = column(stepped, "stamp_s") - column(plain, "stamp_s")
    after = column(plain, "mid_s") - ORIGIN_S >= 4.0
    assert jump == pytest.approx(np.where(after, -0.13, 0.0), abs=1e-9)
    assert [row._replace(stamp_s=None) for row in stepped] == [row._replace(stamp_s=None) for row in plain]
    other = {**effect, "clock": "frames"}
    assert exposures(other, frames=600, stamped=True) == plain
