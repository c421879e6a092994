"""Play between a motor and a link: what momentum and geometry say, and without play the joint without a gear."""

import numpy as np
import pytest

from stillarm.simulation.arm.geared_joint import link_of, play_run
from stillarm.simulation.arm.torque_joint import LAWS, LinearJoint, torque_run, transition

STEP_S = 0.001
TIMES = np.arange(1501) * STEP_S


@pytest.mark.parametrize("bounce", [0.0, 0.4])
def test_across_the_play_the_link_stands_and_then_goes_with_the_motor(bounce: float) -> None:
    """Constant torque: the motor alone crosses half the gap at gain / share; then both go on at one velocity, or part
    at a share of the velocity at which they met."""
    share, gain, gap = 0.25, 2.0, 0.02
    out = np.empty((400, 4))
    u = np.ones((400, 2))
    starts, law = np.array([0, 400]), np.zeros(len(LAWS))
    phi, g = transition(LinearJoint(0.0), STEP_S)
    held, contact = np.ascontiguousarray(g[:, 2]), np.empty(400)
    play_run(
        share, gain, 0.0, gap, bounce, law, phi, held, u, 1, STEP_S, starts, np.zeros((1, 4)), out, contact
    )
    meets = np.sqrt(gap * share / gain)
    before = TIMES[:400] < meets - 2 * STEP_S
    assert np.max(np.abs(out[before, 0])) == 0.0
    assert out[before, 2] == pytest.approx(0.5 * gain / share * TIMES[:400][before] ** 2, abs=1e-9)
    after = TIMES[:400] > meets + 2 * STEP_S
    if bounce:
        parts = out[after, 1][0] - out[after, 3][0]
        since = TIMES[:400][after][0] - meets
        assert parts == pytest.approx(bounce * gain / share * meets - gain / share * since, abs=0.02)
    else:
        assert out[after, 2] - out[after, 0] == pytest.approx(0.5 * gap, abs=1e-9)
    # momentum is kept at the impact: all of gain t is there
    momentum = share * out[after, 3] + (1.0 - share) * out[after, 1]
    assert momentum == pytest.approx(gain * TIMES[:400][after], rel=0.02)


def test_without_a_gap_it_is_the_joint_without_a_gear() -> None:
    """With a mode and dry friction; both steppers are of first order at a contact, so their steps are small."""
    whole, share, samples, parts = LinearJoint(3.0, 0.8, 0.0, ((14.0, 0.02, 0.4, 1.2),)), 0.4, 1500, 8
    law = np.array([{"coulomb_positive": 0.5, "coulomb_negative": 0.5}.get(name, 0.0) for name in LAWS])
    fine = np.linspace(0.0, 1.5, samples * parts + 1)
    u = 2.0 * np.sin(5.0 * fine) + np.sin(17.0 * fine + 1.0)
    fed = np.ascontiguousarray(np.column_stack([u[:-1], u[1:]]))
    starts, step = np.array([0, samples]), STEP_S / parts
    phi, g = transition(whole, step)
    plain, forces = np.empty((samples, 4)), np.empty((samples, 2))
    both = np.array([phi, phi]), np.array([g, g]), np.array([law, law])
    torque_run(*both, samples, fed, parts, step, starts, np.zeros((1, 4)), plain, forces)
    phi, g = transition(link_of(whole, share), step)
    geared, contact = np.empty((samples, 6)), np.empty(samples)
    linear, held = (whole.gain, whole.damping), np.ascontiguousarray(g[:, 2])
    play_run(
        share, *linear, 0.0, 0.0, law, phi, held, fed, parts, step, starts, np.zeros((1, 6)), geared, contact
    )
    assert np.max(np.abs(geared[:, :4] - plain)) < 2e-3 * np.max(np.abs(plain))
    assert geared[:, 4] == pytest.approx(geared[:, 0], abs=1e-12)
