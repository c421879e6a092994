"""What a run's rows hold."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.benchmarks.live.run import damped_settling_s, frames_lost
from stillarm.benchmarks.live.scoring import score
from tests.fixtures.live_rows import W, perfect, true_run


def test_settling_counts_from_the_strike_to_the_last_time_above() -> None:
    truth = true_run()
    said = perfect(truth)
    wrong = np.where((said.time_s >= 2.0) & (said.time_s < 5.0), 0.5 * said.deflection_m, said.deflection_m)
    assert score(replace(said, deflection_m=wrong), truth)["settled_s"] == pytest.approx(3.0, abs=0.3)
    damped = damped_settling_s(truth, 2.5)
    assert damped == pytest.approx(np.log(20.0) / (0.13 * W), abs=0.25)


def test_frames_between_the_first_and_the_last_that_are_missing_are_lost() -> None:
    assert frames_lost([]) == 0 and frames_lost([5, 6, 7]) == 0 and frames_lost([5, 8, 9]) == 2
