"""Composite control against an arm integrated apart from the controller."""

from math import pi

import numpy as np
import pytest

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.configuration import Damping
from stillarm.common.files.model import Arm, Drive, Mode, Model
from stillarm.common.user_error import UserError
from stillarm.controller.command.composite import CompositeControl
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.loop.step import Controller
from tests.reference.arm_world import Trace, constant, run_world

A = 0.00625
W = 2 * pi * 2.6
MODEL = Model(arm=Arm(length_m=2.0, modes=[Mode(damping_ratio=0.01)]))


def run(
    duration_s: float,
    model: Model = MODEL,
    ratio: float = 0.12,
    law: str = "composite",
    method: str = "kalman_constant_delay",
    **world: object,
) -> Trace:
    damping = Damping(law=law, added_damping_ratio=ratio)  # type: ignore[arg-type]
    controller = Controller(model, Settings(arm_at_start=True, method=method, damping=damping))
    world = {"strikes": {1.0: A}, "delay": constant(0.074), "damping": lambda t: True, **world}
    return run_world(model, controller, duration_s, **world)  # type: ignore[arg-type]


def damping_ratio(trace: Trace, from_s: float, to_s: float) -> float:
    """From the envelope's fall between the halves of a span."""
    a = trace.arrays()
    first, last = np.array_split(a["truth"][(a["time"] >= from_s) & (a["time"] < to_s)], 2)
    return float(np.log(np.std(first) / np.std(last)) / (0.5 * (to_s - from_s)) / W)


def frequency_hz(trace: Trace, from_s: float, to_s: float) -> float:
    """From the zero crossings in a span."""
    a = trace.arrays()
    span = (a["time"] >= from_s) & (a["time"] < to_s)
    t, q = a["time"][span], a["truth"][span]
    places = np.flatnonzero(np.diff(np.sign(q)))
    crossings = t[places] - q[places] * 0.001 / (q[places + 1] - q[places])
    return float((len(crossings) - 1) / 2 / (crossings[-1] - crossings[0]))


@pytest.mark.slow
@pytest.mark.parametrize("bandwidth_hz", [6.0, 20.0])
def test_it_adds_the_damping_and_leaves_the_frequency(bandwidth_hz: float) -> None:
    """(s + b)(s^2 + 2 (zeta + zeta_a) w s + w^2): also with a drive whose lag is a quarter of the period's phase."""
    model = Model(arm=MODEL.arm, drive=Drive(bandwidth_hz=bandwidth_hz))
    trace = run(3.0, model, 0.06, method="correlation")
    assert damping_ratio(trace, 1.4, 3.0) == pytest.approx(0.07, abs=0.008)
    assert frequency_hz(trace, 1.4, 2.6) == pytest.approx(2.6, rel=0.015)


@pytest.mark.slow
def test_an_image_offset_never_makes_the_joint_creep() -> None:
    """200 px of constant offset under noise."""
    a = run(
        13.0,
        method="correlation",
        strikes={1.0: A, 4.0: -A},
        image_offset_px=200.0,
        image_noise_px=0.05,
        accelerometer_noise=0.5,
    ).arrays()
    late = a["time"] > 10.0
    assert np.ptp(a["joint"][late]) < 2e-4
    assert np.max(np.abs(a["joint"][late])) < 1e-3
    assert np.max(np.abs(a["truth"][late])) < 0.05 * A


@pytest.mark.slow
def test_after_a_move_the_joint_is_where_the_reference_led_it() -> None:
    """0.2 rad with damping on, as the camera sees it."""
    a = run(
        14.0, strikes={}, reference=lambda t: 0.2 if 3.0 <= t < 4.0 else 0.0, image_noise_px=0.05
    ).arrays()
    assert a["joint"][-1] == pytest.approx(0.2, abs=0.003)
    assert np.max(np.abs(a["truth"][-1000:])) < 0.1 * A


@pytest.mark.slow
def test_the_image_brings_back_a_joint_whose_encoder_drifts() -> None:
    """The encoder creeps by 5 mrad: the velocity law follows it with the joint, the image keeps the joint in place."""

    def drift(read: CycleInput) -> None:
        read.joint_position_rad += 0.005 * min(max((read.cycle * 0.001 - 3.0) / 4.0, 0.0), 1.0)

    ends = {law: run(18.0, law=law, change_input=drift).joint[-1] for law in ("velocity", "composite")}
    assert ends["velocity"] == pytest.approx(-0.005, abs=0.001)
    assert abs(ends["composite"]) < 0.001


@pytest.mark.slow
def test_an_image_with_another_zero_is_no_motion_of_the_joint() -> None:
    """A supervisor that starts again, and a jump that nothing announces: the joint stays."""

    def jump(read: CycleInput) -> None:
        for k, sample in enumerate(read.samples):
            shift = 0.0 if read.cycle < 4000 else 300.0 if read.cycle < 7000 else 150.0
            frame = sample.frame - (260 if read.cycle >= 4000 else 0)
            shown = sample.displacement_x_px + shift
            read.samples[k] = VisualSample(frame, sample.started_cycle, 0, displacement_x_px=shown)

    a = run(11.0, change_input=jump).arrays()
    quiet = ((a["time"] > 6.0) & (a["time"] < 7.0)) | (a["time"] > 9.0)
    assert np.max(np.abs(a["joint"][quiet])) < 3e-3


def test_a_return_faster_than_the_image_allows_is_refused() -> None:
    """An integrator behind a delay of 0.46 s is unstable below 0.29 s; with a gain margin of two, below 0.59 s."""
    model = Model(arm=Arm(length_m=2.0))
    CompositeControl(model, 2.0, 1.0, 0.6)
    with pytest.raises(UserError, match=r"return_time_s = 0\.3"):
        CompositeControl(model, 2.0, 1.0, 0.3)
