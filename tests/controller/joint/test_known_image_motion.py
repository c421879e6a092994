"""The joint's motion is subtracted from the image at the image's estimated date: the rate of that motion is
known, and a wrong date is not taken for an impact.
"""

from math import cos, pi, sin

import numpy as np
import pytest

from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.model import Arm, Mode, Model
from stillarm.controller.estimation.kalman.kalman_method import KalmanMethod
from stillarm.controller.estimation.sine_method import SineMethod
from stillarm.controller.joint.joint_motion import JointMotion
from stillarm.controller.joint.known_image_motion import forced_rate_m_s, joint_image_rate_m_s
from stillarm.controller.joint.sensor_deflection import SensorDeflection
from stillarm.controller.loop.step import Controller, MethodAcrossRestarts
from tests.reference.arm_world import run_world, white

MODEL = Model(arm=Arm(length_m=2.0, modes=[Mode(damping_ratio=0.002)]))
A = 0.00625


def wave(time_s: float) -> float:
    """Joint velocity reference that bends the arm by twice the struck amplitude, and moves the image by far more."""
    return 0.15 * sin(2.0 * pi * 1.1 * time_s)


def test_the_rates_are_those_of_what_is_taken_off() -> None:
    """A joint that moves as a sine: the slopes of what the image is corrected by."""
    joint, sensors = JointMotion(MODEL, 2.0), SensorDeflection(MODEL, 2.0)
    for cycle in range(2000):
        joint.begin_cycle(cycle, 0.1 * sin(6.0 * cycle * 1e-3))
        joint.send(0.6 * cos(6.0 * cycle * 1e-3))
    for time_s in (1.2, 1.5, 1.9):
        seen = sensors.of_image(0.0, joint.position_at(time_s + 0.01)) - sensors.of_image(
            0.0, joint.position_at(time_s - 0.01)
        )
        assert joint_image_rate_m_s(sensors, joint, time_s) == pytest.approx(-seen / 0.02, rel=0.01, abs=2e-3)
        assert joint_image_rate_m_s(sensors, joint, time_s) == pytest.approx(
            2.0 * 0.6 * cos(6.0 * time_s), rel=0.05, abs=0.05
        )
        forced = joint.forced_deflection_at(time_s + 0.01) - joint.forced_deflection_at(time_s - 0.01)
        assert forced_rate_m_s(joint, time_s) == pytest.approx(forced / 0.02, rel=0.02, abs=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["timestamps", "correlation"])
def test_a_joint_that_moves_does_not_cut_the_window(method: str) -> None:
    """With time stamps half a frame early the joint's motion is subtracted at the wrong instant; this must
    not count as an impact.
    """
    controller = Controller(MODEL, Settings(method=method))
    across = controller.method
    assert isinstance(across, MethodAcrossRestarts)
    sine = across._method
    assert isinstance(sine, SineMethod)
    cuts: list[float] = []
    broken = sine._broken
    sine._broken = lambda captured, samples: (cuts.append(captured), broken(captured, samples))[1]  # type: ignore[method-assign, func-returns-value]
    run_world(
        MODEL, controller, 6.0, strikes={0.2: A}, delay=white(0.074, 0.003), started_before_mid_s=0.0077,
        reference=wave, accelerometer_noise=0.2, image_noise_px=0.05,
    )  # fmt: skip
    assert len([cut for cut in cuts if cut > 0.5]) <= 2


@pytest.mark.slow
@pytest.mark.parametrize("method", ["kalman_variable_delay", "kalman_fusion"])
def test_a_joint_that_moves_does_not_begin_the_filter_anew(method: str) -> None:
    """As above: without the variance for misdating a tenth of the images would lie outside the gate."""
    controller = Controller(MODEL, Settings(method=method))
    across = controller.method
    assert isinstance(across, MethodAcrossRestarts)
    kalman = across._method
    assert isinstance(kalman, KalmanMethod)
    begun: list[float] = []
    begin = kalman._begin
    kalman._begin = lambda captured, value: (begun.append(captured), begin(captured, value))[1]  # type: ignore[method-assign, func-returns-value]
    trace = run_world(
        MODEL, controller, 6.0, strikes={0.2: A}, delay=white(0.074, 0.003), started_before_mid_s=0.0077,
        reference=wave, accelerometer_noise=0.2, image_noise_px=0.05,
    )  # fmt: skip
    assert len(begun) == 1
    late = np.array(trace.time) > 1.5
    assert np.isfinite(np.array(trace.estimate)[late]).all()
