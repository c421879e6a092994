"""Stretches the frame period and nothing else."""

import numpy as np
import pytest

from tests.fixtures.exposures import column, exposures


def test_skew_stretches_the_frame_period_and_nothing_else() -> None:
    plain, skewed = (
        exposures(std_s=0.0),
        exposures({"cause": "camera_clock_skew", "skew_ppm": 500.0}, std_s=0.0),
    )
    assert np.diff(column(skewed, "start_s")) == pytest.approx(1.0005 / 65.0, abs=1e-12)
    delays = [column(rows, "handover_s") - column(rows, "mid_s") for rows in (plain, skewed)]
    assert delays[0] == pytest.approx(delays[1], abs=1e-9)
