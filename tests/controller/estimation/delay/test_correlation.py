"""The correlation's delay against a known one: its biases, which the paper leaves in, must be gone."""

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.configuration import Damping
from stillarm.common.files.model import Accelerometer, Arm, Camera, Mode, Model, Timing
from stillarm.controller.estimation.estimate import Status
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.loop.step import Controller, CycleOutput
from tests.reference.arm_world import constant, run_world

AMPLITUDE = 0.00625
HELD_S = 0.0005  # a sample waits half a cycle on average until a cycle reads it


def controller_for(model: Model, **changes: object) -> Controller:
    return Controller(model, Settings(arm_at_start=True, method="correlation", **changes))  # type: ignore[arg-type]


def delays(model: Model, duration_s: float, from_s: float, **world: object) -> tuple[np.ndarray, np.ndarray]:
    trace = run_world(model, controller_for(model), duration_s, **world).arrays()  # type: ignore[arg-type]
    late = trace["delay_time"] > from_s
    return trace["delay_error"][late], trace["delay_std"][late]


def arm(**mode: float) -> Arm:
    return Arm(length_m=2.0, modes=[Mode(**mode)])


@pytest.mark.slow
@given(
    delay_s=st.floats(0.02, 0.15),
    frequency_hz=st.floats(1.5, 4.0),
    damping_ratio=st.floats(0.002, 0.03),
    offset_px=st.floats(-200.0, 200.0),
    sign=st.sampled_from((-1.0, 1.0)),
    bias=st.floats(-1.0, 1.0),
)
@settings(max_examples=10, deadline=None, derandomize=True, phases=[Phase.explicit, Phase.generate])
def test_without_noise_the_delay_is_found_to_a_fraction_of_a_cycle(
    delay_s: float, frequency_hz: float, damping_ratio: float, offset_px: float, sign: float, bias: float
) -> None:
    """For any delay, frequency, damping (the lead 2 zeta / w), signs, image offset and accelerometer bias."""
    model = Model(
        arm=arm(frequency_hz=frequency_hz, damping_ratio=damping_ratio),
        accelerometer=Accelerometer(scale=-0.8 * sign),
        camera=Camera(scale_px_per_m=900.0 * sign, exposure_s=0.0),
        timing=Timing(capture_delay_s=min(max(delay_s, 0.03), 0.12)),
    )

    def add_bias(read: object) -> None:
        read.acceleration_m_s2 += bias  # type: ignore[attr-defined]

    errors, _ = delays(
        model, 4.0, 2.5, strikes={0.2: AMPLITUDE}, delay=constant(delay_s),
        image_offset_px=offset_px, change_input=add_bias,
    )  # fmt: skip
    assert abs(np.mean(errors)) < 0.0006
    assert np.max(np.abs(errors)) < 0.0016  # half a cycle of dating, and what the growing window leaves


@pytest.mark.slow
def test_with_the_papers_noise_the_error_is_as_large_as_it_is_said_to_be() -> None:
    """Accelerometer noise 0.3 of the amplitude: the stated deviation covers the error, and is not idle."""
    model = Model(arm=arm())
    ratios, biases = [], []
    for seed in range(6):
        errors, stds = delays(
            model, 6.0, 2.0, strikes={0.2: AMPLITUDE}, delay=constant(0.074), seed=seed,
            accelerometer_noise=0.5, image_noise_px=0.05,
        )  # fmt: skip
        ratios.append(np.mean(errors**2) / np.mean(stds**2))
        biases.append(np.mean(errors))
        assert np.sqrt(np.mean(errors**2)) < 0.0025
    assert 0.15 < np.mean(ratios) < 1.8
    assert abs(np.mean(biases)) < 0.001


@pytest.mark.slow
def test_damping_does_not_bias_the_delay() -> None:
    """Taking length theta'' instead of (1 - sum of participations) length theta'' off gave 8.6 ms (paper-notes.md)."""
    model = Model(arm=arm())
    settings = Settings(arm_at_start=True, method="correlation", damping=Damping(added_damping_ratio=0.06))
    trace = run_world(
        model, Controller(model, settings), 4.0, strikes={0.5 * k + 0.2: AMPLITUDE for k in range(8)},
        delay=constant(0.074), damping=lambda t: True, accelerometer_noise=0.01,
    ).arrays()  # fmt: skip
    late = trace["delay_time"] > 1.5
    assert np.max(np.abs(trace["command"])) > 0.003  # it does damp
    assert abs(np.mean(trace["delay_error"][late])) < 0.0015


@pytest.mark.slow
def test_a_moving_joint_does_not_bias_the_delay() -> None:
    """A slow wave of the joint larger than the vibration."""
    model = Model(arm=arm())
    errors, _ = delays(
        model, 6.0, 2.0, strikes={0.2: AMPLITUDE}, delay=constant(0.074),
        reference=lambda t: 0.02 * np.sin(2 * np.pi * 0.3 * t),
    )  # fmt: skip
    assert abs(np.mean(errors)) < 0.0015


@pytest.mark.slow
def test_a_delay_of_the_filter_is_taken_out() -> None:
    """model.accelerometer.delay_s: what the sensor's filter adds must not look like a shorter capture delay."""
    plain = Model(arm=arm())
    told = Model(arm=arm(), accelerometer=Accelerometer(delay_s=0.004))
    world = {"strikes": {0.2: AMPLITUDE}, "delay": constant(0.074)}
    found, _ = delays(plain, 4.0, 2.0, **world)
    updated, _ = delays(told, 4.0, 2.0, **world)
    assert np.mean(updated) - np.mean(found) == pytest.approx(0.004, abs=2e-4)


@pytest.mark.slow
def test_a_vanishing_vibration_holds_the_delay_and_widens_its_uncertainty() -> None:
    """Small vibration: held, the same number, growing deviation; before any vibration: unestimated."""
    model = Model(arm=arm(damping_ratio=0.05))
    trace = run_world(
        model, controller_for(model), 12.0, strikes={1.0: AMPLITUDE}, delay=constant(0.070),
        accelerometer_noise=0.5, image_noise_px=0.05,
    )  # fmt: skip
    said = {t: out.estimate.delay for t, out in zip(trace.time, trace.outputs, strict=True)}
    assert said[0.9].status is Status.UNESTIMATED
    assert said[2.5].status is Status.ESTIMATED
    assert said[8.0].status is Status.HELD
    assert said[11.0].delay_s == said[8.0].delay_s
    assert said[11.0].std_s > said[8.0].std_s > said[2.5].std_s
    assert said[11.9].std_s <= 1.001 * max(model.timing.capture_delay_std_s, said[8.0].std_s)


@pytest.mark.slow
def test_missing_accelerometer_samples_are_skipped() -> None:
    """A third of the samples missing, in bursts, must not move the delay."""
    model = Model(arm=arm())

    def drop(read: object) -> None:
        if read.cycle % 30 < 10:  # type: ignore[attr-defined]
            read.acceleration_m_s2 = float("nan")  # type: ignore[attr-defined]

    errors, _ = delays(model, 5.0, 2.5, strikes={0.2: AMPLITUDE}, delay=constant(0.074), change_input=drop)
    assert abs(np.mean(errors)) < 0.0015


@pytest.mark.slow
def test_a_recording_at_half_the_rate_gives_the_same_delay() -> None:
    """Rows every second cycle only: the average is one over time, not over rows."""
    model = Model(arm=arm())
    kept = Controller(model, Settings(arm_at_start=True, method="correlation"))

    class EverySecond:
        def step(self, read: CycleInput) -> CycleOutput:
            self.waiting = [*getattr(self, "waiting", []), *read.samples]
            if read.cycle % 2 == 0:
                read.samples, self.waiting = self.waiting, []
                self.last = kept.step(read)
            return self.last

    trace = run_world(model, EverySecond(), 4.0, strikes={0.2: AMPLITUDE}, delay=constant(0.074)).arrays()  # type: ignore[arg-type]
    late = trace["delay_time"] > 2.0
    assert abs(np.mean(trace["delay_error"][late]) - 0.0005) < 0.001  # read half a cycle later on average
