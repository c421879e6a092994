"""The encoder's noise is no motion; a motion is noticed within a few cycles."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.controller.estimation.fused.arm.resting_joint import RestingJoint


@settings(max_examples=20, deadline=None)
@given(noise_rad=st.floats(1e-7, 1e-4), place_rad=st.floats(-1.0, 1.0), seed=st.integers(0, 999))
def test_noise_alone_keeps_it_at_rest(noise_rad: float, place_rad: float, seed: int) -> None:
    """Held within a quarter of the encoder's noise of where it stands, for five seconds."""
    random, joint = np.random.default_rng(seed), RestingJoint()
    for cycle in range(5000):
        joint.see(place_rad + noise_rad * float(random.standard_normal()), noise_rad**2)
        if cycle > 200:
            assert joint.resting
            assert abs(joint.held_rad - place_rad) < 0.5 * noise_rad


@settings(max_examples=20, deadline=None)
@given(noise_rad=st.floats(1e-7, 1e-5), speed=st.floats(0.02, 1.0), seed=st.integers(0, 999))
def test_a_motion_ends_the_rest_at_once(noise_rad: float, speed: float, seed: int) -> None:
    """Within a dozen cycles of a start at 0.02 rad/s or more; its end is a rest again within a fifth of a second."""
    random, joint = np.random.default_rng(seed), RestingJoint()
    positions = np.concatenate((np.zeros(300), speed * 0.001 * np.arange(200), np.full(300, speed * 0.2)))
    states = []
    for one in positions + noise_rad * random.standard_normal(len(positions)):
        joint.see(float(one), noise_rad**2)
        states.append(joint.resting)
    assert states[299]
    assert not any(states[312:500])
    assert states[-50]


def test_a_joint_without_an_encoder_rests_from_the_start() -> None:
    joint = RestingJoint()
    for _ in range(200):
        joint.see(0.0, 0.0)
    assert joint.resting and joint.held_rad == 0.0
