"""The torque-driven joint against an independent integrator, and against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from stillarm.simulation.arm.torque_joint import (
    LAWS,
    LinearJoint,
    exponential,
    torque_run,
    transition,
)

Array = NDArray[np.float64]
STEP_S, SAMPLES = 0.001, 1500
FLEXIBLE = LinearJoint(3.0, 0.8, 0.0, ((14.0, 0.02, 0.4, 1.2), (70.0, 0.01, 0.1, 0.7)))


def _run(linear: LinearJoint, u: Array, samples: int = SAMPLES, **laws: float) -> Array:
    """States at each sample from rest; u at the samples, linear between them."""
    phi, g = transition(linear, STEP_S)
    law = np.array([laws.get(name, 0.0) for name in LAWS])
    n = len(phi)
    out, forces = np.empty((samples, n)), np.empty((samples, 2))
    fed = np.ascontiguousarray(np.column_stack([u[:samples], u[1 : samples + 1]]))
    starts = np.array([0, samples])
    both = np.array([phi, phi]), np.array([g, g]), np.array([law, law])
    torque_run(*both, samples, fed, 1, STEP_S, starts, np.zeros((1, n)), out, forces)
    return out


def _torque(t: float) -> float:
    return float(2.0 * np.sin(5.0 * t) + np.sin(17.0 * t + 1.0))


TIMES = np.arange(SAMPLES + 1) * STEP_S
INPUT = np.array([_torque(t) for t in TIMES])


def _solved(linear: LinearJoint, **laws: float) -> Array:
    """The same by an adaptive Runge-Kutta method, from the equations as the docstring has them; friction by a steep
    tanh."""

    def rate(t: float, z: Array) -> Array:
        theta, omega = z[0], z[1]
        torque = linear.gain * np.interp(t, TIMES, INPUT) - linear.damping * omega - linear.stiffness * theta
        torque -= laws.get("coulomb_positive", 0.0) * np.tanh(omega / 1e-4)
        torque += laws.get("gravity_sine", 0.0) * np.sin(theta)
        torque += laws.get("ripple_cosine", 0.0) * np.cos(laws.get("ripple_cycles", 0.0) * theta)
        torque -= laws.get("viscous_square", 0.0) * omega * abs(omega)
        for i, (w, zeta, _, pull) in enumerate(linear.modes):
            torque += pull * (w * w * z[2 + 2 * i] + 2.0 * zeta * w * z[3 + 2 * i])
        out = np.empty_like(z)
        out[0], out[1] = omega, torque
        for i, (w, zeta, follows, _) in enumerate(linear.modes):
            q, v = z[2 + 2 * i], z[3 + 2 * i]
            out[2 + 2 * i] = v
            out[3 + 2 * i] = -w * w * q - 2.0 * zeta * w * v - follows * torque
        return out

    n = 2 + 2 * len(linear.modes)
    solved = solve_ivp(
        rate, (0.0, TIMES[-1]), np.zeros(n), t_eval=TIMES[:SAMPLES], rtol=1e-9, atol=1e-12, max_step=STEP_S,
        method="LSODA" if "coulomb_positive" in laws else "RK45",
    )  # fmt: skip
    return np.asarray(solved.y.T)


def _difference(ours: Array, theirs: Array) -> float:
    return float(np.max(np.abs(ours - theirs) / np.max(np.abs(theirs), axis=0)))


@pytest.mark.slow
def test_the_linear_part_obeys_the_equations() -> None:
    """To what an adaptive integrator makes of an input with a corner at every sample."""
    assert _difference(_run(FLEXIBLE, INPUT), _solved(FLEXIBLE)) < 1e-5


def test_the_linear_part_is_exact() -> None:
    a, b = FLEXIBLE.equations()
    n = len(a)
    large = np.zeros((n + 2, n + 2))
    large[:n, :n], large[:n, n], large[n, n + 1] = a * STEP_S, b[:, 0] * STEP_S, 1.0
    step = expm(large)
    z, expected = np.zeros(n), []
    for k in range(SAMPLES):
        expected.append(z)
        z = step[:n, :n] @ z + step[:n, n] * INPUT[k] + step[:n, n + 1] * (INPUT[k + 1] - INPUT[k])
    assert _difference(_run(FLEXIBLE, INPUT), np.array(expected)) < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize(
    ("laws", "within"),
    [
        ({"gravity_sine": -4.0}, 1e-5),
        ({"ripple_cosine": 1.5, "ripple_cycles": 25.0}, 1e-3),
        ({"viscous_square": 2.0}, 1e-3),
        ({"coulomb_positive": 1.2, "coulomb_negative": 1.2}, 5e-3),
    ],
)
def test_laws_agree_with_an_adaptive_integrator(laws: dict[str, float], within: float) -> None:
    rigid = replace(FLEXIBLE, modes=())
    theirs = _solved(rigid, **laws)
    ours = _run(rigid, INPUT, **laws)
    assert _difference(ours, theirs) < within
    assert _difference(_run(rigid, INPUT), theirs) > 10.0 * within


def test_a_joint_below_its_friction_stays_where_it_is_and_does_not_creep() -> None:
    out = _run(LinearJoint(1.0), np.full(SAMPLES + 1, 0.99), coulomb_positive=1.0, coulomb_negative=1.0)
    assert np.max(np.abs(out)) < 1e-12


def test_a_free_hub_rings_higher_than_a_held_one() -> None:
    """w sqrt(1 + pull b): the hinged-free frequency of one mode."""
    w, follows, pull = 20.0, 0.5, 1.6
    a, _ = LinearJoint(1.0, 0.0, 0.0, ((w, 0.0, follows, pull),)).equations()
    assert np.max(np.imag(np.linalg.eigvals(a))) == pytest.approx(w * np.sqrt(1.0 + pull * follows))


@settings(deadline=None, max_examples=30)
@given(st.integers(2, 8), st.floats(1e-4, 300.0), st.integers(0, 1000))
def test_the_exponential_is_scipys(size: int, scale: float, seed: int) -> None:
    matrix = np.random.default_rng(seed).standard_normal((size, size))
    matrix *= min(scale, 20.0) / np.linalg.norm(matrix)
    expected = expm(matrix)
    assert np.max(np.abs(exponential(matrix) - expected)) < 1e-11 * np.max(np.abs(expected))
