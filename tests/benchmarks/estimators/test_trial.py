"""How a trial is judged: known errors give known figures, and a method gets what the world did."""

from dataclasses import replace
from math import nan

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from stillarm.benchmarks.estimators.trial import (
    Answers,
    assumed_model,
    run_method,
    samples_by_cycle,
    scale_error,
    score,
    scored_cycles,
    scored_frames,
)
from stillarm.benchmarks.estimators.world.generator import Data, generate
from stillarm.benchmarks.estimators.world.regimes import CYCLE_S, REGIMES, Arm
from stillarm.common.files.model import Commissioned
from stillarm.controller.estimation.estimate import Trust

DATA = generate(REGIMES["freerun drift"], 0.3, (1,), 9.0, Arm())


def answers(data: Data, error: float = 0.0, delay_error_s: float = 0.0) -> Answers:
    """Right but for `error` of the momentary amplitude and `delay_error_s`; stated deviations twice the errors."""
    cycles = len(data.deflection_m)
    return Answers(
        data.deflection_m + error * data.amplitude_m,
        2.0 * abs(error) * data.amplitude_m + 1e-12,
        data.frames.delay_s + delay_error_s,
        np.full(len(data.frames.number), 2.0 * abs(delay_error_s) + 1e-12),
        np.full(cycles, 5.0),
        np.full(cycles, Trust.SETTLED.value),
    )


def test_the_scales_are_off_by_as_much_as_the_model_says() -> None:
    """Of 400 trials; the same trial has the same error."""
    model = assumed_model(REGIMES["freerun drift"], 0.3)
    assert isinstance(model.commissioned, Commissioned)
    std = model.commissioned.std
    stated = np.hypot(std["camera.scale_px_per_m"] / model.camera.scale_px_per_m, std["accelerometer.scale"])
    drawn = [scale_error((1, trial, 0)) for trial in range(400)]
    assert np.sqrt(np.mean(np.square(drawn))) == pytest.approx(stated, rel=0.1)
    assert scale_error((1, 7, 0)) == drawn[7]


def test_the_truth_scores_zero() -> None:
    """No error anywhere, and a correlation of one."""
    found = score(DATA, answers(DATA))
    assert found.error_max_all == found.delay_rms_s == found.delay_normalised_error_squared == 0.0
    assert found.pmcc == pytest.approx(1.0)
    assert found.us_mean == found.us_median == 5.0


@given(error=st.floats(-0.5, 0.5), delay_error_s=st.floats(-0.02, 0.02))
@settings(max_examples=20, deadline=None, derandomize=True, phases=[Phase.explicit, Phase.generate])
def test_a_known_error_is_found_as_such(error: float, delay_error_s: float) -> None:
    """As a fraction of the momentary amplitude; bias with its sign; normalised squares of a quarter."""
    found = score(DATA, answers(DATA, error, delay_error_s))
    assert found.error_mean == pytest.approx(abs(error))
    assert found.error_max == pytest.approx(abs(error))
    assert found.delay_bias_s == pytest.approx(delay_error_s)
    assert found.delay_rms_s == pytest.approx(abs(delay_error_s))
    if abs(error) > 1e-4:
        assert found.deflection_normalised_error_squared == pytest.approx(0.25, rel=1e-4)
    if abs(delay_error_s) > 1e-4:
        assert found.delay_normalised_error_squared == pytest.approx(0.25, rel=1e-4)


def test_silence_counts_as_a_prediction_of_zero() -> None:
    """A method that says nothing must not look good by it."""
    said = answers(DATA)
    silent = replace(said, deflection_m=np.full(len(said.deflection_m), nan))
    found = score(DATA, silent)
    assert found.unanswered == 1.0
    assert found.error_mean == pytest.approx(2.0 / np.pi, rel=0.05)
    mute = replace(said, delay_s=np.full(len(said.delay_s), nan))
    assert score(DATA, mute).delay_rms_s == pytest.approx(0.074)


def test_what_is_scored_leaves_out_settling_and_impacts_and_nothing_else() -> None:
    """An error right after an impact shows in the *_all figures only; one half a second later shows in both."""
    impact = round(float(DATA.motion.impacts_s[1]) / CYCLE_S)
    for since, hidden in ((100, True), (490, True), (510, False)):
        said = answers(DATA)
        said.deflection_m[impact + since] += DATA.amplitude_m[impact + since]
        found = score(DATA, said)
        assert found.error_max_all == pytest.approx(1.0)
        assert found.error_max == pytest.approx(0.0 if hidden else 1.0)
    cycles = scored_cycles(DATA)
    assert not cycles[:2000].any()
    left_out = [min(0.5, 9.003 - time) for time in DATA.motion.impacts_s if time > 2.0]
    assert cycles.sum() == pytest.approx(7000 - sum(left_out) / CYCLE_S, abs=3)


def test_of_several_frames_in_a_cycle_the_last_is_scored() -> None:
    """The estimate after a cycle is that of its newest frame."""
    data = generate(REGIMES["freerun jitter"], 0.3, (3,), 9.0, Arm())
    read, scored = data.frames.read_cycle, scored_frames(data)
    assert len(set(read[scored].tolist())) == scored.sum()
    shared = np.flatnonzero(np.diff(read) == 0)
    assert len(shared) > 0
    assert not scored[shared].any()


def test_frames_that_a_method_may_not_have_come_to_are_not_scored() -> None:
    """Those of the last 20 cycles; the ones before are."""
    data = generate(REGIMES["freerun constant"], 0.3, (4,), 2.6, Arm(impact_every_s=(9.0, 10.0)))
    read, scored = data.frames.read_cycle, scored_frames(data)
    late = read >= 2600 - 20
    assert late.any()
    assert not scored[late].any()
    assert scored[(read >= 2000) & ~late].all()


def test_samples_show_what_the_camera_saw_when_it_was_read() -> None:
    """Every frame once, in order, in its cycle; a static scene moves against the camera."""
    by_cycle = samples_by_cycle(DATA)
    samples = [(cycle, sample) for cycle in sorted(by_cycle) for sample in by_cycle[cycle]]
    assert [sample.frame for _, sample in samples] == DATA.frames.number.tolist()
    assert [cycle for cycle, _ in samples] == DATA.frames.read_cycle.tolist()
    shown = np.array([sample.displacement_x_px for _, sample in samples]) / -800.0
    true = DATA.motion.at(DATA.frames.exposed_s)[0]
    assert (shown - true - np.mean(shown - true)).std() == pytest.approx(0.01 * DATA.arm.amplitude_m, rel=0.1)
    deeper = samples_by_cycle(DATA, 0.8)
    first = next(iter(sorted(by_cycle)[5:]))
    assert deeper[first][0].displacement_x_px == pytest.approx(0.8 * by_cycle[first][0].displacement_x_px)


def test_timestamps_are_late_by_half_a_frame_as_their_law_says() -> None:
    """A method whose error is known in advance: eq. 1 errs by n_i's lead, half a frame on average over trials."""
    biases = []
    for seed in range(4):
        data = generate(REGIMES["freerun constant"], 0.3, (seed, 2), 5.0, Arm())
        said = run_method("timestamps", data, assumed_model(data.regime, 0.3))
        lead = data.frames.exposed_s - data.frames.started_cycle * CYCLE_S
        biases.append(score(data, said).delay_bias_s)
        frames = scored_frames(data)
        assert biases[-1] == pytest.approx(np.mean(lead[frames]), abs=1e-9)
    assert 0.003 < np.mean(biases) < 0.013


def test_a_run_repeats_to_the_bit() -> None:
    """The same data and method: the same answers."""
    data = generate(REGIMES["triggered jitter"], 0.3, (4,), 3.0, Arm())
    first, again = (run_method("correlation", data, assumed_model(data.regime, 0.3)) for _ in range(2))
    assert np.array_equal(first.deflection_m, again.deflection_m, equal_nan=True)
    assert np.array_equal(first.delay_s, again.delay_s)
