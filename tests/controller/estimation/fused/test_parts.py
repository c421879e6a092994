"""The parts of the fused method by themselves."""

from cmath import exp
from math import nan

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.controller.estimation.fused.arrivals import ArrivalSpread
from stillarm.controller.estimation.fused.bank import Law
from stillarm.controller.estimation.fused.blocks import Block
from stillarm.controller.estimation.fused.dating import Dating
from stillarm.controller.estimation.fused.impact import ImpactDetector
from stillarm.controller.estimation.fused.joint_input import JointInput

FRAME_S = 1.0 / 65.0
once = settings(max_examples=15, deadline=None, derandomize=True, phases=[Phase.explicit, Phase.generate])


@once
@given(frequency_hz=st.floats(1.0, 15.0), joint_hz=st.floats(0.2, 4.0), skip=st.integers(1, 5))
def test_the_phasors_increments_move_it_as_the_modal_equation_does(
    frequency_hz: float, joint_hz: float, skip: int
) -> None:
    """Undamped q'' + w^2 q = -p L theta'' in closed form; one stretch of cycles never comes."""
    w, lever, wj = 2 * np.pi * frequency_hz, 2.3, 2 * np.pi * joint_hz
    if abs(w - wj) < 0.2 * w:
        return
    joint = JointInput([w], [-lever / w], 0.001)
    cycle = 0
    while cycle < 800:
        cycle += skip if cycle == 400 else 1
        t = cycle * 0.001
        joint.advance(cycle, [exp(1j * w * t)], float(np.sin(wj * (t - 0.0005))), 0.0)
    t = cycle * 0.001
    exact = -lever / (w * w - wj * wj) * (np.sin(wj * t) - wj / w * np.sin(w * t))
    found = (joint.sum[0] * exp(1j * w * t)).real
    size = lever / abs(w * w - wj * wj) * (1 + wj / w)
    assert found == pytest.approx(exact, abs=0.02 * size)


@once
@given(
    size=st.floats(0.3, 3.0),
    onset=st.integers(2, 8),
    seed=st.integers(0, 50),
    sign=st.sampled_from((-1.0, 1.0)),
)
def test_an_impact_is_found_with_its_size_and_onset(size: float, onset: int, seed: int, sign: float) -> None:
    """Blocks of 16 ms with noise of a fortieth: within two blocks of its onset."""
    random = np.random.default_rng(seed)
    detector = ImpactDetector([16.3], 0.016)
    for k in range(20):
        after = (k - onset + 0.5) * 0.016
        value = 0.025 * random.standard_normal() + (sign * size * np.sin(16.3 * after) if after > 0 else 0.0)
        impact = detector.see(Block(0.016 * k, 0.016 * (k + 1), 16), value, 0.025**2, 1.0)
        if impact is not None:
            assert abs(k + 1 - impact.blocks_ago - onset) <= 2
            assert 0.3 * size < impact.sizes_m[0] < 3.0 * size
            return
    pytest.fail("the impact was not seen")


def test_noise_alone_is_no_impact() -> None:
    """Twenty seconds of it."""
    random = np.random.default_rng(3)
    detector = ImpactDetector([16.3], 0.016)
    found = [
        detector.see(Block(0.016 * k, 0.016 * (k + 1), 16), float(random.standard_normal()), 1.0, 10.0)
        for k in range(1250)
    ]
    assert all(impact is None for impact in found)


@pytest.mark.parametrize(("white_s", "walk"), [(0.002, 0.0), (0.0004, 2e-6), (0.0, 0.0)])
def test_white_spread_and_wander_of_arrivals_are_told_apart(white_s: float, walk: float) -> None:
    """The structure function gives both back within a factor of two and a half; steady arrivals are steady."""
    random = np.random.default_rng(4)
    spread = ArrivalSpread(FRAME_S, 0.0064, 0.001)
    level = 0.0
    for _ in range(4000):
        level += np.sqrt(walk * FRAME_S) * random.standard_normal()
        spread.add(float(level + white_s * random.standard_normal()))
    white = max(white_s**2 + 0.5 * walk * FRAME_S, 0.001**2 / 12)
    assert 0.7 * white < spread.white < 1.4 * white
    if walk:
        assert 0.6 * walk < spread.walk < 3.5 * walk
    else:
        assert spread.walk < 1e-6


def test_no_walk_is_seen_in_white_noise_nor_before_enough_is_known() -> None:
    """White noise of 6.4 ms: a wander below a twentieth of it in a square root second is believed after 40 s."""
    random = np.random.default_rng(6)
    for _ in range(5):
        spread = ArrivalSpread(FRAME_S, 0.0064, 0.001)
        for count in range(2600):
            assert spread.known == (count >= 256 + 64)
            spread.add(float(0.0064 * random.standard_normal()))
        assert spread.walk < (0.05 * 0.0064) ** 2


def frame(number: int, captured_s: float = nan) -> VisualSample:
    return VisualSample(number, 0, 0, 1.0, captured_s=captured_s)


def test_frames_are_counted_by_the_counter_and_a_reset_by_the_time_passed() -> None:
    """Lost frames by the counter's jump; a counter that falls to zero by the clock; old frames not at all."""
    dating = Dating(FRAME_S, 0.074)
    assert dating.accept(frame(100), 1.0)
    assert dating.accept(frame(103), 1.0 + 3 * FRAME_S)
    assert dating.nominal[Law.CLOCK] == pytest.approx(0.926 + 3 * FRAME_S)
    assert dating.doubt_s == 0.0
    assert not dating.accept(frame(103), 1.0 + 3.1 * FRAME_S)
    assert not dating.accept(frame(101), 1.0 + 3.2 * FRAME_S)
    assert dating.accept(frame(0), 1.0 + 5.1 * FRAME_S)
    assert dating.nominal[Law.CLOCK] == pytest.approx(0.926 + 5 * FRAME_S)
    assert dating.doubt_s > 0.0


def test_a_frame_that_is_very_late_by_chance_is_no_jump_of_the_counter() -> None:
    """40 ms after the others, with those behind it at once: known for it where the delay spreads by 6.4 ms."""
    dating = Dating(FRAME_S, 0.074, 0.0064)
    assert dating.accept(frame(0), 1.0)
    assert dating.accept(frame(1), 1.0 + FRAME_S + 0.040)
    assert dating.accept(frame(2), 1.0 + FRAME_S + 0.041)
    assert dating.nominal[Law.CLOCK] == pytest.approx(0.926 + 2 * FRAME_S)
    for more in range(4):  # six were lost, as the next three tell, which come in their own time
        assert dating.accept(frame(3 + more), 1.0 + FRAME_S + 0.041 + (6 + more) * FRAME_S)
    assert dating.nominal[Law.CLOCK] == pytest.approx(0.926 + 11 * FRAME_S)
    assert dating.doubt_s > 0.0


def test_a_stall_is_no_loss() -> None:
    """Six frames' time late, its successors in a burst: all were there, and only waited."""
    dating = Dating(FRAME_S, 0.074, 0.0064)
    for k in range(10):
        assert dating.accept(frame(k), 1.0 + k * FRAME_S)
    for k in range(10, 18):
        assert dating.accept(frame(k), 1.0 + 17 * FRAME_S + 0.001 * (k - 10))
    for k in range(18, 30):
        assert dating.accept(frame(k), 1.0 + k * FRAME_S)
    assert dating.nominal[Law.CLOCK] == pytest.approx(0.926 + 29 * FRAME_S)


def test_stamps_that_jump_are_doubted() -> None:
    """A step of the camera's clock does not move the frames by itself."""
    dating = Dating(FRAME_S, 0.074)
    for k in range(3):
        dating.accept(frame(k, 50.0 + k * FRAME_S), 1.0 + k * FRAME_S)
    before = float(dating.nominal[Law.STAMPS])
    assert dating.stamped
    dating.accept(frame(3, 90.0), 1.0 + 3 * FRAME_S)
    assert dating.stamp_doubt_s > 0.0
    assert dating.nominal[Law.STAMPS] - before == pytest.approx(FRAME_S)


def test_instants_that_are_no_numbers_return_what_is_held() -> None:
    """NaN cast to an integer once kept numpy's take(mode="wrap") busy for ever."""
    joint = JointInput([16.0], [1.0], 0.001)
    for cycle in range(20):
        joint.advance(cycle, [1.0 + 0j], 0.0, 0.25)
    theta, rate, grown = joint.seen_from(float("nan"), np.array((float("nan"), float("inf"), -1e300)))
    assert theta.tolist() == [0.25] * 3 and rate.tolist() == [0.0] * 3
    assert np.all(np.isfinite(grown))
