"""A strain gauge in place of the accelerometer, and a clipped accelerometer."""

from math import nan

import numpy as np
import pytest

from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.configuration import Kalman
from stillarm.common.files.model import Accelerometer, Model
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.loop.recorded import fast_sample, recorded_cycles
from stillarm.controller.loop.step import Controller
from tests.fixtures.kalman_trials import MODEL, A, mean_error, run
from tests.reference.arm_world import constant, run_world


@pytest.mark.slow
def test_a_strain_gauge_is_fused_in_the_accelerometers_place() -> None:
    """An offset and noise of 5 % of the amplitude; the camera's constant delay is 10 ms off, which the gauge mends."""

    def gauge(read: CycleInput) -> None:
        read.deflection_m = 0.002 - read.acceleration_m_s2 / MODEL.arm.modes[0].angular_frequency ** 2
        read.deflection_m += 0.05 * A * np.sin(1e4 * read.cycle)  # as good as noise, and the same every time
        read.acceleration_m_s2 = nan

    kalman = Kalman(fusion_sensor="strain_gauge", fusion_delay="model", strain_noise_m=0.05 * A)
    world = {"delay": constant(0.084), "accelerometer_noise": 0.0, "change_input": gauge}
    assert mean_error(run("kalman_fusion", 4.0, kalman, **world), 1.5) < 0.04
    assert mean_error(run("kalman_constant_delay", 4.0, **world), 1.5) > 0.08


def test_a_measured_deflection_survives_recording() -> None:
    """From the cycle to /fast and back, to the bit."""
    read = CycleInput(5, deflection_m=0.1 + 0.2, joint_position_rad=0.0)
    row = fast_sample(read, Controller(MODEL, Settings(arm_at_start=True)).step(read), 0.001)
    (again,) = recorded_cycles([row], [])
    assert again.read.deflection_m == 0.1 + 0.2


@pytest.mark.slow
def test_a_clipped_accelerometer_is_not_believed() -> None:
    """A range below the vibration's peak: samples at the range's end are none."""
    model = Model(arm=MODEL.arm, accelerometer=Accelerometer(range_m_s2=1.0))

    def clip(read: CycleInput) -> None:
        read.acceleration_m_s2 = min(max(read.acceleration_m_s2, -1.0), 1.0)

    controller = Controller(model, Settings(arm_at_start=True, method="kalman_fusion"))
    trace = run_world(
        model, controller, 4.0, strikes={0.2: A}, delay=constant(0.074), accelerometer_noise=0.1,
        image_noise_px=0.05, change_input=clip,
    )  # fmt: skip
    assert mean_error(trace, 1.5) < 0.03
