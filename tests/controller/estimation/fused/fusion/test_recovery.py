"""Bad starts, and a clock's time through pulls and releases, in the benchmark's own world."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.benchmarks.estimators.conditions_table import open_trial, seed_of
from stillarm.benchmarks.estimators.trial import (
    assumed_model,
    run_method,
    scale_error,
    score,
    scored_cycles,
)
from stillarm.benchmarks.estimators.world.generator import generate
from stillarm.benchmarks.estimators.world.regimes import REGIMES, Arm

LIVE = REGIMES["live"]


@pytest.mark.slow
def test_a_queue_that_drains_while_the_arm_swings_is_no_force() -> None:
    """The images come 100 ms later than said and leave their gates. A force as large as the vibration was made from
    that: 140 % of the amplitude wrong from 2.0 to 2.5 s, and still 80 % half a second later."""
    seed = 0, 9, list(REGIMES).index("live")
    data = generate(LIVE, 0.3, seed, 40.0, Arm())
    begun = replace(data, acceleration_m_s2=data.acceleration_m_s2[:4000])  # no more is judged
    answers = run_method("fused", begun, assumed_model(LIVE, 0.3), 1.0 + scale_error(seed))
    error = np.abs(answers.deflection_m - data.deflection_m[:4000]) / data.amplitude_m[:4000]
    assert float(error[scored_cycles(data)[:4000]].max()) < 0.08


@pytest.mark.slow
def test_a_clock_keeps_its_time_while_a_hand_pulls_and_lets_go() -> None:
    """Doubted by half a frame at each pull and each release, it was 0.64 ms off after the last of six releases."""
    trial = open_trial("release", REGIMES["freerun drift"], seed_of(0, 0, "release"))
    data = trial.data
    answers = run_method("fused", data, trial.model, trial.scale)
    read_s = 1e-3 * data.frames.read_cycle
    error = (answers.delay_s - data.frames.delay_s)[read_s > data.motion.forced_s[-1][1] + 0.2]
    assert float(np.sqrt(np.nanmean(error**2))) < 0.3e-3


@pytest.mark.slow
def test_a_beginning_that_the_accelerometer_never_confirms_is_made_again() -> None:
    """Images 140 ms later than said taught a scale off by half, which muted the accelerometer for good: `settled`,
    and 22 % wrong for 25 s."""
    trial = open_trial("supervisor restarted", LIVE, seed_of(0, 6, "supervisor restarted"))
    answers = run_method("fused", trial.data, trial.model, trial.scale)
    scored = score(trial.data, answers, trial.condition.from_s)
    assert scored.error_mean < 0.01 and scored.deflection_normalised_error_squared < 3.0


@pytest.mark.slow
def test_a_hand_that_pulls_an_arm_at_rest_makes_no_new_beginning() -> None:
    """The accelerometer shows nothing of a slow pull. With a beginning anew in it, the estimate was wrong by four
    amplitudes after a release."""
    trial = open_trial("release", REGIMES["triggered drift"], seed_of(0, 2, "release"))
    answers = run_method("fused", trial.data, trial.model, trial.scale)
    scored = score(trial.data, answers, trial.condition.from_s)
    assert scored.error_mean < 0.01 and scored.error_max < 0.4
