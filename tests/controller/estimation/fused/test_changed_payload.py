"""An arm that takes up a payload: its frequency falls at once, unannounced, and the estimate finds its way back."""

import pytest

from stillarm.benchmarks.estimators.conditions_table import ConditionJob, withstand


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "trial"), [(5, 9), (0, 3)])
def test_a_payload_that_looks_like_impacts_is_found_out(seed: int, trial: int) -> None:
    """Frequency 10 % lower from 20 s on; the accelerometer takes it for an impact, or contradicts the images.

    Of twenty trials the worst two: taken for impacts and then for a steady force it took twenty seconds to be learnt.
    """
    job = ConditionJob("payload at 20 s: frequency -10 %", "triggered drift", trial, seed, ("fused",))
    score = withstand(job).scores["fused"]
    assert score.error_mean < 0.025
    assert score.error_last < 0.01
