"""Input shaping: exact on the mode, tolerant as said, causal; and on an arm integrated apart from the controller."""

from cmath import exp
from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.model import Arm, Mode, Model
from stillarm.controller.command.shaping import ReferenceShaper, zv_taps, zvd_taps
from stillarm.controller.loop.step import Controller
from tests.reference.arm_world import constant, run_world

CYCLE_S = 0.001


def residual(taps: list[tuple[int, float]], mode: Mode, cycle_s: float) -> float:
    """Vibration left after the last tap, as a share of that of the unshaped input."""
    w, zeta = mode.angular_frequency, mode.damping_ratio
    pole = complex(-zeta * w, w * sqrt(1.0 - zeta * zeta)) * cycle_s
    return abs(sum(a * exp(-pole * k) for k, a in taps)) * abs(exp(pole * taps[-1][0]))


modes = st.builds(Mode, frequency_hz=st.floats(0.2, 40.0), damping_ratio=st.floats(0.0, 0.3))


@given(mode=modes, cycle_s=st.floats(0.0005, 0.004))
@settings(max_examples=150, derandomize=True)
def test_the_mode_is_not_excited_at_all(mode: Mode, cycle_s: float) -> None:
    """Zero to rounding, for half periods of any fraction of a cycle; positive amplitudes that add up to 1."""
    for taps in (zv_taps(mode, cycle_s), zvd_taps(mode, cycle_s)):
        assert residual(taps, mode, cycle_s) < 1e-9
        assert sum(a for _, a in taps) == pytest.approx(1.0, abs=1e-12)
        assert all(a > 0.0 for _, a in taps)
        assert [k for k, _ in taps] == sorted({k for k, _ in taps})


def test_whole_half_periods_give_the_textbook_amplitudes() -> None:
    """K = exp(-zeta pi / sqrt(1 - zeta^2)): 1/(1+K), K/(1+K); and 1, 2K, K^2 over (1+K)^2."""
    zeta = 0.05
    mode = Mode(frequency_hz=0.5 / (0.2 * sqrt(1 - zeta * zeta)), damping_ratio=zeta)
    big_k = np.exp(-zeta * pi / sqrt(1 - zeta * zeta))
    for taps, wanted in (
        (zv_taps(mode, CYCLE_S), ((0, 1.0), (200, big_k))),
        (zvd_taps(mode, CYCLE_S), ((0, 1.0), (200, 2 * big_k), (400, big_k**2))),
    ):
        whole = sum(amplitude for _, amplitude in wanted)
        for place, amplitude in wanted:  # rounding may put a trace of it into the next cycle
            near = sum(a for k, a in taps if abs(k - place) <= 2)
            assert near == pytest.approx(amplitude / whole, abs=1e-9)


@pytest.mark.parametrize("error", [-0.1, 0.1])
def test_zvd_tolerates_a_tenth_of_the_frequency_and_zv_does_not(error: float) -> None:
    """Of a mode without damping: ZV leaves sin(pi/2 e) = 15.6 %, ZVD the square of that."""
    true = Mode(frequency_hz=2.6 * (1 + error), damping_ratio=0.0)
    assumed = Mode(frequency_hz=2.6, damping_ratio=0.0)
    assert residual(zv_taps(assumed, CYCLE_S), true, CYCLE_S) == pytest.approx(0.156, abs=0.002)
    assert residual(zvd_taps(assumed, CYCLE_S), true, CYCLE_S) < 0.03


@given(values=st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=30), seed=st.integers(0, 99))
@settings(max_examples=40, derandomize=True)
def test_causal_linear_and_complete(values: list[float], seed: int) -> None:
    """The convolution with the taps, no more; a constant comes through unchanged in the end."""
    mode = Mode(frequency_hz=30.0, damping_ratio=0.02)
    shaper, taps = ReferenceShaper("zvd", mode, CYCLE_S), zvd_taps(mode, CYCLE_S)
    for n in range(len(values) + 60):
        held = values[n] if n < len(values) else 0.7
        wanted = sum(
            a * ((values[n - k] if n - k < len(values) else 0.7) if n >= k else 0.0) for k, a in taps
        )
        assert shaper.shape(seed + n, held) == pytest.approx(wanted, abs=1e-12)
    assert shaper.shape(seed + len(values) + 60, 0.7) == pytest.approx(0.7)


def test_none_hands_through_and_skipped_cycles_do_no_harm() -> None:
    """Bit for bit; and after a stall of any length the reference comes through in the end."""
    mode = Mode()
    assert ReferenceShaper("none", mode, CYCLE_S).shape(0, 0.3) == 0.3
    shaper = ReferenceShaper("zv", mode, CYCLE_S)
    for n in (0, 1, 2, 50, 51, 5000, 5001):
        said = shaper.shape(n, 0.2)
        assert 0.0 <= said <= 0.2 + 1e-12
    assert said == pytest.approx(0.2)


def left_after_a_move(shaping: str, frequency_factor: float) -> tuple[float, float]:
    """Residual vibration, m, and final joint position, rad, of an arm that was moved by 0.1 rad."""
    model = Model(arm=Arm(length_m=2.0, modes=[Mode(damping_ratio=0.01)]))
    controller = Controller(
        model, Settings(arm_at_start=True, method="timestamps", reference_shaping=shaping)
    )  # type: ignore[arg-type]
    trace = run_world(
        model, controller, 1.6, strikes={}, delay=constant(0.074), frequency_factor=frequency_factor,
        reference=lambda t: 0.2 if 0.1 <= t < 0.6 else 0.0,
    ).arrays()  # fmt: skip
    late = trace["time"] > 1.1
    return float(np.max(np.abs(trace["truth"][late]))), float(trace["joint"][-1])


@pytest.mark.slow
def test_a_move_leaves_the_arm_at_rest() -> None:
    """A twentieth and less of the unshaped vibration, and the same way gone; ZVD also with a frequency 10 % off."""
    plain, way = left_after_a_move("none", 1.0)
    assert plain > 0.003
    for shaping in ("zv", "zvd"):
        vibration, position = left_after_a_move(shaping, 1.0)
        assert vibration < 0.01 * plain
        assert position == pytest.approx(way, abs=1e-6)
    for factor in (0.9, 1.1):
        off, _ = left_after_a_move("none", factor)
        assert left_after_a_move("zvd", factor)[0] < 0.06 * off
