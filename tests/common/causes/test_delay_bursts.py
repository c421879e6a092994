"""Bursts at their rate and of their length, that keep the order."""

import numpy as np
import pytest

from stillarm.simulation.camera.camera_timing import TRANSFER_S
from tests.fixtures.exposures import column, exposures


@pytest.mark.slow
def test_bursts_come_at_their_rate_last_their_time_and_keep_the_order() -> None:
    effect = {"cause": "delay_bursts", "rate_hz": 0.2, "duration_s": 0.5, "delay_s": 0.06}
    frames = 130_000  # 2000 s
    plain, late = exposures(frames=frames, std_s=0.0), exposures(effect, frames=frames, std_s=0.0)
    more = column(late, "handover_s") - column(plain, "handover_s")
    assert np.all(np.diff(column(late, "handover_s")) >= TRANSFER_S - 1e-9)
    held = more > 0.06 - 1e-9
    # an M/D/inf process: the share of time with no burst under way is exp(-rate duration)
    assert np.mean(held) == pytest.approx(1.0 - np.exp(-0.2 * 0.5), rel=0.12)
    assert np.max(more) == pytest.approx(0.06, abs=1e-9)
    begins = np.flatnonzero(held[1:] & ~held[:-1])
    lengths = [int(np.argmin(held[b + 1 :])) for b in begins[:-1]]
    assert min(lengths) >= int(0.5 * 65.0)
    # one that another prolongs is longer: 1 - exp(-0.1) of them at most
    assert np.mean(np.array(lengths) <= int(0.5 * 65.0) + 1) > 0.85
    # after it the queue empties one transfer apart: 60 ms of delay is gone within a few frames
    caught_up = (more > 1e-9) & ~held
    assert np.sum(caught_up) / len(begins) == pytest.approx(0.06 / (1.0 / 65.0 - TRANSFER_S), abs=1.0)
