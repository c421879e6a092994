"""Damping in closed loop, against an arm integrated apart from the controller."""

from cmath import exp as complex_exp
from math import exp, nan, pi

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.configuration import Damping
from stillarm.common.files.model import Arm, Drive, Mode, Model
from stillarm.controller.command.damping import DampingStatus, JointDamping, most_damping_lag_s
from stillarm.controller.estimation.estimate import DelayEstimate, Estimate, Status
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.loop.step import Controller
from tests.reference.arm_world import constant, run_world

A = 0.00625
SETTINGS = Settings(arm_at_start=True, method="correlation")


def model(participation: float = 1.14) -> Model:
    return Model(arm=Arm(length_m=2.0, modes=[Mode(participation=participation)]))


def decay_ratio(t: np.ndarray, q: np.ndarray, from_s: float, to_s: float) -> float:
    """Damping ratio from the energy-like envelope between two times."""
    span = (t >= from_s) & (t < to_s)
    first, last = np.array_split(q[span], 2)
    return float(np.log(np.std(first) / np.std(last)) / (0.5 * (to_s - from_s)) / (2 * pi * 2.6))


@pytest.mark.slow
@pytest.mark.parametrize("participation", [1.14, -0.8])
def test_the_added_damping_is_what_was_asked_for(participation: float) -> None:
    """k = 2 zeta_a w / (p L) adds zeta_a = 0.06 to 0.01, for either sign of the participation."""
    arm = model(participation)
    settings = Settings(arm_at_start=True, method="correlation", damping=Damping(added_damping_ratio=0.06))
    trace = run_world(
        arm, Controller(arm, settings), 4.0, strikes={1.0: A}, delay=constant(0.074), damping=lambda t: True
    ).arrays()
    assert decay_ratio(trace["time"], trace["truth"], 1.4, 3.0) == pytest.approx(0.07, abs=0.008)


def decay_per_s(ratio: float, added: float, w: float, lag_s: float) -> float:
    """Of the first mode under a joint velocity that trails the deflection: the root of s^2 + 2 zeta w s + w^2 +
    2 zeta_a w s exp(-s lag) = 0, by secants from the root without a lag."""

    def characteristic(s: complex) -> complex:
        return s * s + 2.0 * ratio * w * s + w * w + 2.0 * added * w * s * complex_exp(-s * lag_s)

    s, before = complex(-(ratio + added) * w, w), complex(-(ratio + added) * w, 1.01 * w)
    while abs(s - before) > 1e-9 * w:
        f = characteristic(s)
        s, before = s - f * (s - before) / (f - characteristic(before)), s
    return -s.real


@given(
    added=st.floats(0.03, 0.35),
    ratio=st.floats(0.001, 0.05),
    w=st.floats(3.0, 100.0),
    away=st.floats(0.4, 1.0),
)
def test_a_joint_that_trails_by_the_most_damping_lag_damps_most(
    added: float, ratio: float, w: float, away: float
) -> None:
    lag = most_damping_lag_s(ratio + added, w)
    most = decay_per_s(ratio, added, w, lag)
    assert most > (ratio + added) * w
    assert decay_per_s(ratio, added, w, (1.0 + away) * lag) < most
    assert decay_per_s(ratio, added, w, (1.0 - away) * lag) < most


@pytest.mark.slow
def test_a_dead_time_known_damps_more_than_one_mistaken_either_way() -> None:
    def damped(assumed_s: float) -> float:
        rig, known = (Model(arm=model().arm, drive=Drive(dead_time_s=late)) for late in (0.02, assumed_s))
        controller = Controller(known, Settings(arm_at_start=True, method="correlation", damping=Damping()))
        trace = run_world(
            rig, controller, 3.0, strikes={1.0: A}, delay=constant(0.074), damping=lambda t: True
        ).arrays()
        return decay_ratio(trace["time"], trace["truth"], 1.4, 2.4)

    right = damped(0.02)
    assert right > 0.13
    assert max(damped(0.003), damped(0.037)) < 0.98 * right


@pytest.mark.slow
def test_an_image_offset_never_makes_the_joint_creep() -> None:
    """200 px of constant offset, and a joint that starts away from its commanded position's zero."""
    arm = model()
    trace = run_world(
        arm, Controller(arm, SETTINGS), 20.0, strikes={1.0: A, 4.0: -A}, delay=constant(0.074),
        damping=lambda t: True, image_offset_px=200.0, image_noise_px=0.05, accelerometer_noise=0.5,
    ).arrays()  # fmt: skip
    late = trace["time"] > 15.0
    assert np.max(np.abs(trace["joint"][late])) < 5e-5
    assert np.max(np.abs(trace["truth"][late])) < 0.05 * A


@pytest.mark.slow
def test_damping_while_the_joint_moves_returns_to_the_commanded_position() -> None:
    """A move of 0.3 rad with damping on: the joint ends where the reference led it, the arm at rest."""
    arm = model()

    def reference(t: float) -> float:
        return 0.3 if 1.0 <= t < 2.0 else 0.0

    trace = run_world(
        arm, Controller(arm, SETTINGS), 16.0, strikes={}, delay=constant(0.074),
        damping=lambda t: True, reference=reference, image_noise_px=0.05, accelerometer_noise=0.5,
    ).arrays()  # fmt: skip
    assert trace["joint"][-1] == pytest.approx(0.3, abs=0.003)
    assert np.max(np.abs(trace["truth"][-1000:])) < 0.1 * A


@pytest.mark.slow
def test_the_command_is_zero_within_a_fifth_of_a_second_of_the_last_image() -> None:
    """For any motion of the arm; damping resumes with the images."""
    arm = model()

    def cut(read: CycleInput) -> None:
        if 2000 <= read.cycle < 2600:
            read.samples.clear()

    trace = run_world(
        arm, Controller(arm, SETTINGS), 4.0, strikes={1.8: A, 2.55: A}, delay=constant(0.074),
        damping=lambda t: True, change_input=cut,
    ).arrays()  # fmt: skip
    command, t = trace["command"], trace["time"]
    assert np.max(np.abs(command[(t > 1.9) & (t < 2.0)])) > 0.003
    assert np.all(command[(t >= 2.2) & (t < 2.6)] == 0.0)
    assert np.max(np.abs(command[(t > 2.9) & (t < 3.3)])) > 0.001


def test_a_silent_drive_and_a_lost_permission_stop_the_damping() -> None:
    """Each with its own status, each at zero."""
    damping = JointDamping(model(), Damping(), "model")
    estimate = Estimate(DelayEstimate(0.07, 0.001, Status.ESTIMATED), 0.005, 0.0, 1e-4, Status.ESTIMATED)
    damping.see_sample(1.0)
    for k in range(300):
        damping.see_sample(1.0 + k * 0.001)
        velocity, status = damping.velocity_rad_s(estimate, 1.0 + k * 0.001, True, 0.0, 0.0)
    assert status is DampingStatus.ACTIVE
    assert velocity > 0.0
    assert damping.velocity_rad_s(estimate, 1.3, True, 0.0, 0.5) == (0.0, DampingStatus.DRIVE_SILENT)
    for k in range(300):
        damping.see_sample(1.3 + k * 0.001)
        velocity, status = damping.velocity_rad_s(estimate, 1.3 + k * 0.001, False, 0.0, 0.0)
    assert (velocity, status) == (0.0, DampingStatus.OFF)


@given(
    deflection=st.one_of(st.floats(), st.just(nan)), rate=st.floats(), joint=st.floats(), age=st.floats(),
    time_s=st.floats(0.0, 1e6),
)  # fmt: skip
@example(deflection=0.0, rate=0.0, joint=nan, age=0.0, time_s=0.0)
@settings(max_examples=200)
def test_the_damping_part_is_always_finite_and_bounded(
    deflection: float, rate: float, joint: float, age: float, time_s: float
) -> None:
    """Any numbers at all."""
    damping = JointDamping(model(), Damping(), "model")
    estimate = Estimate(
        DelayEstimate(0.07, 0.001, Status.ESTIMATED), deflection, rate, 1e-4, Status.ESTIMATED
    )
    damping.see_sample(time_s)
    damping.follow_reference(0.0, 0.0, 1)
    for _ in range(3):
        velocity, _ = damping.velocity_rad_s(estimate, time_s, True, joint, age)
        assert abs(velocity) <= Damping().max_velocity_rad_s


def estimate_of(deflection_m: float, std_m: float, delay_std_s: float = 0.001) -> Estimate:
    return Estimate(
        DelayEstimate(0.07, delay_std_s, Status.ESTIMATED), deflection_m, 0.0, std_m, Status.ESTIMATED
    )


@pytest.mark.parametrize(
    ("estimate", "begins"),
    [
        (estimate_of(0.006, 0.0003), True),
        (estimate_of(0.001, 0.0003), True),  # little known of little: it commands next to nothing
        (estimate_of(0.088, 0.019), False),  # three frames of another zero, as a fit has taken them
        (estimate_of(0.006, 0.002), False),
        (estimate_of(0.006, 0.002, delay_std_s=0.04), True),  # the delay's doing, which no waiting mends
        (estimate_of(0.006, nan), True),  # a method that tells none
    ],
)
def test_damping_begins_on_a_prediction_that_is_sure(estimate: Estimate, begins: bool) -> None:
    """And where it has begun, it is not given up for a moment's doubt."""
    damping = JointDamping(model(), Damping(), "model")
    doubtful = estimate_of(0.006, 0.002)

    def run(estimate: Estimate, from_s: float) -> DampingStatus:
        for k in range(300):
            damping.see_sample(from_s + k * 0.001)
            _, status = damping.velocity_rad_s(estimate, from_s + k * 0.001, True, 0.0, 0.0)
        return status

    assert run(estimate, 1.0) is (DampingStatus.ACTIVE if begins else DampingStatus.NO_PREDICTION)
    run(estimate_of(0.006, 0.0003), 2.0)
    assert run(doubtful, 3.0) is DampingStatus.ACTIVE


@given(
    held=st.floats(-0.05, 0.05),
    deflection=st.floats(-0.003, 0.003),
    rate=st.floats(-0.05, 0.05),
    law=st.sampled_from(("velocity", "composite")),
)
def test_what_a_force_holds_is_not_damped(held: float, deflection: float, rate: float, law: str) -> None:
    """The command is that for the vibration alone: an arm that is held aside at rest asks for nothing."""

    def commanded(static_m: float) -> float:
        delay = DelayEstimate(0.07, 0.001, Status.ESTIMATED)
        estimate = Estimate(delay, deflection + static_m, rate, 1e-5, Status.ESTIMATED, static_m=static_m)
        damping = JointDamping(model(), Damping(law=law), "model")
        for k in range(300):
            damping.see_sample(1.0 + k * 0.001)
            velocity, status = damping.velocity_rad_s(estimate, 1.0 + k * 0.001, True, 0.0, 0.0)
        assert status is DampingStatus.ACTIVE
        return velocity

    assert commanded(held) == pytest.approx(commanded(0.0), abs=1e-9)
    if abs(deflection) > 0.001 and abs(rate) < 0.001:
        assert abs(commanded(held)) > 1e-4


def test_envelope_helper() -> None:
    """The judge itself: a known decay gives its own ratio back."""
    t = np.arange(0, 4, 0.001)
    q = np.array([exp(-0.07 * 2 * pi * 2.6 * x) * np.cos(2 * pi * 2.6 * x) for x in t])
    assert decay_ratio(t, q, 0.4, 2.0) == pytest.approx(0.07, abs=0.003)
