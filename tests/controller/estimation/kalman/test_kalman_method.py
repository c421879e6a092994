"""The Kalman methods against an arm integrated apart from them, and against sensors that fail."""

from collections.abc import Callable
from math import cos, exp, isfinite, nan, pi

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.model import Arm, Mode, Model
from stillarm.controller.estimation.estimate import Observation, Status
from stillarm.controller.estimation.methods import make_method
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.joint.joint_motion import JointMotion
from tests.fixtures.kalman_trials import A, mean_error, run
from tests.reference.arm_world import wandering, white

METHODS = ("kalman_constant_delay", "kalman_variable_delay", "kalman_fusion")


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_a_known_delay_leaves_little_error(method: str) -> None:
    """Constant delay, exact time stamps, the paper's noise."""
    trace = run(method, 4.0)
    assert mean_error(trace, 1.5) < 0.02
    assert trace.outputs[-1].estimate.status is Status.ESTIMATED


@pytest.mark.slow
def test_time_stamps_follow_a_delay_that_a_constant_does_not() -> None:
    """A slow wander of 12 ms with exact stamps."""
    delay = wandering(0.074, 0.012, 2.0)
    variable = mean_error(run("kalman_variable_delay", 5.0, delay=delay, seed=1), 1.5)
    fixed = mean_error(run("kalman_constant_delay", 5.0, delay=delay, seed=1), 1.5)
    assert variable < 0.03 < fixed


@pytest.mark.slow
def test_white_jitter_is_averaged_out() -> None:
    """The constant delay is right in the mean: 6.4 ms of jitter would be 10 % of the amplitude in a single frame."""
    assert mean_error(run("kalman_constant_delay", 5.0, delay=white(0.074, 0.0064)), 1.5) < 0.03


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_the_joints_own_motion_is_a_known_input(method: str) -> None:
    """A wave of the joint larger than the vibration, whose answer of the arm is not free vibration."""
    trace = run(method, 4.0, reference=lambda t: 0.05 * np.sin(2 * pi * 0.8 * t), accelerometer_noise=0.1)
    assert mean_error(trace, 1.5) < 0.04


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_an_impact_is_followed_within_a_fifth_of_a_second(method: str) -> None:
    """Struck again, against the vibration; with an image offset that must not move."""
    trace = run(
        method, 3.5, strikes={0.2: A, 2.03: -1.5 * A}, image_offset_px=80.0, delay=white(0.074, 0.001)
    )
    assert mean_error(trace, 2.03 + 0.2) < 0.06


@pytest.mark.slow
def test_the_stated_deviation_covers_the_error() -> None:
    """The delay wanders slowly and the method takes it as constant: the variance added for the delay covers
    the error.
    """
    ratios = []
    for seed in range(3):
        a = run("kalman_constant_delay", 5.0, delay=wandering(0.074, 0.0064, 2.0), seed=seed).arrays()
        late = a["time"] > 1.0
        ratios.append(np.mean(((a["estimate"] - a["truth"]) / a["estimate_std"])[late] ** 2))
    assert 0.1 < np.mean(ratios) < 1.8


def cut_images(first: int, last: int) -> Callable[[CycleInput], None]:
    def change(read: CycleInput) -> None:
        if first <= read.cycle < last:
            read.samples.clear()

    return change


@pytest.mark.slow
def test_without_images_the_image_alone_is_held_and_the_fusion_goes_on() -> None:
    """Two seconds of gap: a growing deviation and `held`; with the accelerometer a small error and `estimated`."""
    held = run("kalman_constant_delay", 5.5, change_input=cut_images(2000, 4000))
    said = [output.estimate for output in held.outputs]
    assert said[3900].status is Status.HELD
    before = min(estimate.deflection_std_m for estimate in said[1500:1900])  # where no delay can matter
    assert min(estimate.deflection_std_m for estimate in said[3500:3900]) > 2.0 * before
    assert said[-1].status is Status.ESTIMATED
    assert mean_error(held, 4.8) < 0.02
    fused = run("kalman_fusion", 4.0, change_input=cut_images(2000, 4000))
    assert fused.outputs[3900].estimate.status is Status.ESTIMATED
    assert mean_error(fused, 2.5) < 0.05


@pytest.mark.slow
def test_without_an_accelerometer_the_fusion_is_the_image_alone() -> None:
    """Dead from the first sample, or dying: no more error than that of the image alone, no number missing."""

    def kill(read: CycleInput) -> None:
        read.acceleration_m_s2 = nan

    dead = run("kalman_fusion", 4.0, change_input=kill)
    alone = run("kalman_variable_delay", 4.0)
    assert dead.arrays()["estimate"][1500:] == pytest.approx(alone.arrays()["estimate"][1500:], abs=0.02 * A)
    assert dead.outputs[-1].estimate.status is Status.ESTIMATED

    def die(read: CycleInput) -> None:
        if read.cycle > 2000:
            read.acceleration_m_s2 = 25.0  # beyond its range

    assert mean_error(run("kalman_fusion", 4.0, change_input=die), 1.5) < 0.02


def test_without_a_camera_nothing_is_claimed() -> None:
    """No first image: unestimated, no number, no damping."""
    trace = run("kalman_fusion", 1.0, change_input=cut_images(0, 10**6), damping=lambda t: True)
    assert all(output.estimate.status is Status.UNESTIMATED for output in trace.outputs)
    assert not np.any(trace.arrays()["command"])


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_a_supervisor_that_starts_again_has_another_zero(method: str) -> None:
    """Frame numbers from 0, image shifted by 300 px; and a shift that nothing announces."""

    def restart(read: CycleInput) -> None:
        for k, sample in enumerate(read.samples):
            shift = 300.0 if read.cycle > 2000 else 0.0
            shift -= 150.0 if read.cycle > 4000 else 0.0
            frame = sample.frame - (130 if read.cycle > 2000 else 0)
            read.samples[k] = VisualSample(
                frame, sample.started_cycle, 0, displacement_x_px=sample.displacement_x_px + shift
            )

    trace = run(method, 6.5, change_input=restart)
    said = [output.estimate for output in trace.outputs]
    assert said[2150].status is Status.UNESTIMATED
    assert mean_error(trace, 3.0, 4.0) < 0.03
    assert mean_error(trace, 5.2) < 0.03


def two_modes(
    method: str, seconds: float, garbage: Callable[[int], dict[str, float]] | None = None
) -> list[float]:
    """Errors of the deflection of an arm of two ringing modes, m, in closed form; the joint rests."""
    first, second = (
        Mode(damping_ratio=0.002),
        Mode(frequency_hz=11.0, damping_ratio=0.005, participation=-0.2),
    )
    model = Model(arm=Arm(length_m=2.0, modes=[first, second]))
    estimator = make_method(method, model, Settings(), "model")
    joint = JointMotion(model, 2.0)

    def modal(t: float) -> tuple[float, float]:
        return tuple(  # type: ignore[return-value]
            amplitude
            * exp(-m.damping_ratio * 2 * pi * m.frequency_hz * t)
            * cos(2 * pi * m.frequency_hz * t + 1)
            for amplitude, m in ((A, first), (0.4 * A, second))
        )

    errors, frame = [], 0
    for cycle in range(int(seconds * 1000)):
        t = cycle * 0.001
        joint.begin_cycle(cycle, 0.0)
        acceleration = -sum(
            (2 * pi * m.frequency_hz) ** 2 * q for m, q in zip((first, second), modal(t), strict=True)
        )
        samples = []
        while frame / 65 + 0.074 <= t:
            shown = -800.0 * sum(modal(frame / 65))
            samples.append(VisualSample(frame, round(frame / 65 * 1000), 0, displacement_x_px=shown))
            frame += 1
        extra = garbage(cycle) if garbage else {}
        samples = [
            VisualSample(s.frame, s.started_cycle, 0, extra.get("px", s.displacement_x_px)) for s in samples
        ]
        said = estimator.update(
            Observation(
                cycle, t, extra.get("acceleration", acceleration), samples, joint, extra.get("strain", nan)
            )
        )
        assert not said.deflection_std_m < 0.0
        assert isfinite(said.deflection_m) == isfinite(said.deflection_std_m)
        joint.send(0.0)
        errors.append(said.deflection_m - sum(modal(t)))
    return errors


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_all_modes_of_the_model_are_followed(method: str) -> None:
    """The second mode at 40 % of the first: to a twentieth of it; a regression of the first alone leaves it."""
    late = slice(1500, None)
    assert np.std(two_modes(method, 3.0)[late]) < 0.05 * 0.4 * A
    assert np.std(two_modes("timestamps", 3.0)[late]) > 0.2 * 0.4 * A


@pytest.mark.slow
@given(
    seed=st.integers(0, 10**6),
    method=st.sampled_from(METHODS),
    share=st.floats(0.01, 0.9),
)
@settings(max_examples=8, deadline=None, derandomize=True, phases=[Phase.explicit, Phase.generate])
def test_garbage_never_crashes_and_never_states_nonsense(seed: int, method: str, share: float) -> None:
    """Spikes, NaN and stuck values in any sensor: all stated deviations stay finite and positive."""
    random = np.random.default_rng(seed)

    def garbage(cycle: int) -> dict[str, float]:
        if random.uniform() > share:
            return {}
        value = float(random.choice([nan, 0.0, 1e3 * random.standard_normal(), 19.0, -1e6]))
        return {str(random.choice(["px", "acceleration", "strain"])): value}

    two_modes(method, 1.2, garbage)


@pytest.mark.slow
def test_the_same_inputs_give_the_same_numbers() -> None:
    """To the bit: replay relies on it."""
    assert run("kalman_fusion", 1.5).estimate[1000:] == run("kalman_fusion", 1.5).estimate[1000:]
