"""The joint as measured: no departure in noise, a slow one to where the spectra meet, and the modes' answer to it."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.signal import butter, sosfilt

from stillarm.diagnosis.physics.measured_joint import answer_to_joint, departure_hz, smoothed

STEP_S, NOISE = 0.001, 1e-4
TIME = np.arange(20000) * STEP_S
STILL = np.zeros(len(TIME))


def noise(seed: int) -> np.ndarray:
    """An encoder's."""
    return np.random.default_rng(seed).normal(0.0, NOISE, len(TIME))


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 1000))
def test_noise_is_no_departure(seed: int) -> None:
    assert departure_hz(noise(seed), STILL, STEP_S) == 0.0


@pytest.mark.parametrize("missing", [0.1, 0.5, 0.8])
def test_noise_with_samples_missing_is_no_departure(missing: float) -> None:
    seen = noise(1)
    seen[np.random.default_rng(2).random(len(seen)) < missing] = np.nan
    assert departure_hz(seen, STILL, STEP_S) == 0.0


def test_noise_of_an_encoder_read_every_other_cycle_is_no_departure() -> None:
    seen = noise(1)
    seen[::2] = np.nan
    assert departure_hz(seen, STILL, STEP_S) == 0.0


@pytest.mark.parametrize("per_rad", [1e-5, 1e-4, 1e-3])
@pytest.mark.parametrize("speed", [0.0, 0.003, 0.1])
def test_what_rounding_leaves_is_no_departure(per_rad: float, speed: float) -> None:
    """A joint that turns to and fro, slowly and quickly, read by an encoder of so many radians a step."""
    path = 0.3 + speed * np.sin(2.0 * pi * 0.3 * TIME)
    seen = np.round((path + 0.1 * noise(6)) / per_rad) * per_rad
    assert departure_hz(seen, path, STEP_S) == 0.0


def test_a_departure_of_some_steps_is_seen_by_a_coarse_encoder() -> None:
    path = 0.2 * np.sin(2.0 * pi * 0.5 * TIME)
    moved = path + 4e-3 * np.sin(2.0 * pi * 2.0 * TIME)
    assert departure_hz(np.round(moved / 1e-3) * 1e-3, path, STEP_S) >= 2.0


@pytest.mark.parametrize("hz", [3.0, 10.0, 20.0])
def test_a_departure_reaches_to_where_its_spectrum_meets_the_noise(hz: float) -> None:
    """Noise through a filter of known response: its spectrum is four times the encoder's where the response says."""
    random, order, gain = np.random.default_rng(4), 3, 400.0
    slow = sosfilt(
        butter(order, hz, fs=1.0 / STEP_S, output="sos"), random.normal(0.0, gain**0.5 * NOISE, len(TIME))
    )
    # gain / (1 + (f / hz)^6) + 1 = 4
    meets = hz * (gain / 3.0 - 1.0) ** (1.0 / (2 * order))
    found = departure_hz(slow + noise(5), STILL, STEP_S)
    assert found == pytest.approx(min(meets, 40.0), rel=0.25)


def test_too_little_that_is_measured_tells_nothing() -> None:
    seen = np.full(len(TIME), np.nan)
    seen[:400] = 1.0
    assert departure_hz(seen, STILL, STEP_S) == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("hz", [0.5, 4.0, 8.0, 16.0])
def test_what_is_kept_of_a_sine_is_what_an_optimal_smoother_keeps(hz: float) -> None:
    """1 / (1 + (f / f_c)^6), without a shift of phase; the second derivative is that of it."""
    corner, w = 8.0, 2.0 * pi * hz
    kept, second = smoothed(np.sin(w * TIME), corner, STEP_S)
    share, inner = 1.0 / (1.0 + (hz / corner) ** 6), slice(4000, 16000)
    assert kept[inner] == pytest.approx(share * np.sin(w * TIME)[inner], abs=0.01 * share + 1e-3)
    assert second[inner] == pytest.approx(-w * w * kept[inner], abs=0.01 * w * w * share)


@pytest.mark.slow
@pytest.mark.parametrize(("hz", "damping"), [(2.6, 0.004), (9.0, 0.05)])
def test_a_mode_answers_the_joint_as_an_integrator_says(hz: float, damping: float) -> None:
    """q'' + 2 zeta w q' + w^2 q = -p a."""
    w, push, time = 2.0 * pi * hz, 2.4, np.arange(3000) * STEP_S

    def joint(t: float) -> float:
        return float(np.sin(7.0 * t) ** 3)

    solved = solve_ivp(
        lambda t, y: [y[1], -push * joint(t) - 2.0 * damping * w * y[1] - w * w * y[0]],
        (0.0, time[-1]),
        [0.0, 0.0],
        t_eval=time,
        rtol=1e-10,
        atol=1e-13,
    )
    turned = np.array([joint(t) for t in time])
    q, second = answer_to_joint(turned, hz, damping, push, STEP_S)
    wanted = -push * turned - 2.0 * damping * w * solved.y[1] - w * w * solved.y[0]
    allowed = (w * STEP_S) ** 2 / 12.0 * w * time[-1] + 1e-3
    assert np.max(np.abs(q - solved.y[0])) < allowed * np.max(np.abs(solved.y[0]))
    assert np.max(np.abs(second - wanted)) < allowed * np.max(np.abs(wanted))
