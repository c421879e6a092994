"""Adds to the delay evenly from the start."""

import numpy as np
import pytest

from stillarm.simulation.camera.camera_timing import TRANSFER_S
from tests.fixtures.exposures import ORIGIN_S, column, exposures


def test_drift_adds_to_the_delay_evenly_from_the_start() -> None:
    plain, drifting = exposures(), exposures({"cause": "delay_drift", "rate_s_per_s": 5e-4})
    later = column(drifting, "handover_s") - column(plain, "handover_s")
    wanted = 5e-4 * (column(plain, "mid_s") - ORIGIN_S)
    free = np.diff(column(plain, "handover_s")) > 2.0 * TRANSFER_S
    assert np.mean(free) > 0.95
    assert later[1:][free] == pytest.approx(wanted[1:][free], abs=1e-12)
