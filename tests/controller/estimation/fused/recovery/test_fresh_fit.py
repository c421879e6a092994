"""The vibration from the last images alone: exact without noise, honest with it, blind to dates."""

from cmath import exp as complex_exp

import numpy as np
import pytest

from stillarm.common.files.configuration import Fused
from stillarm.common.files.model import Arm, Camera, Model
from stillarm.controller.estimation.fused.arm.joint_input import JointInput
from stillarm.controller.estimation.fused.arm.layout import Layout
from stillarm.controller.estimation.fused.filters import start
from stillarm.controller.estimation.fused.filters.bank import FilterBank
from stillarm.controller.estimation.fused.filters.laws import LAWS
from stillarm.controller.estimation.fused.filters.new_beginning import start_vibration
from stillarm.controller.estimation.fused.recovery.fresh_fit import Fresh, HeldImages, fresh_fit

MODEL = Model(arm=Arm(length_m=2.0), camera=Camera(exposure_s=0.0))
AT = Layout(MODEL, 2.0)
W = AT.w.tolist()
FRAME_S, IMAGE_M, NOW_S = 1.0 / 65.0, 6e-5, 2.0
A, B, FORCE_M = 0.004, -0.003, 0.005


def fitted(
    noise_m: float, force_m: float, *, force: bool, learn: bool, seed: int = 1
) -> tuple[Fresh, FilterBank]:
    """Thirty images of a vibration (A, B) about a force, by filters that know the rest to what a start leaves."""
    random = np.random.default_rng(seed)
    bank = FilterBank(AT, start.variances(MODEL, Fused(), AT, 2.0) * 1e-8, start.jitters_s(MODEL) * 1e-3)
    bank.edge_s = NOW_S - 0.05
    joint = JointInput(W, AT.input_gain, 0.001)
    for cycle in range(2000):
        joint.advance(cycle, [complex_exp(1j * w * cycle * 0.001) for w in W], 0.0, 0.0)
    images = HeldImages()
    for k in range(30):
        time_s = NOW_S - 0.05 - (29 - k) * FRAME_S
        turn = np.exp(-AT.sigma[0] * (time_s - bank.edge_s)) * complex_exp(1j * W[0] * time_s)
        shown = ((A - 1j * B) * turn).real + force_m + noise_m * float(random.standard_normal())
        images.add(np.full(LAWS, time_s), shown, IMAGE_M**2, 30.0)
    window = images.newest(1.2 * AT.period_s, 0, NOW_S)
    assert window is not None
    return fresh_fit(window, bank, AT, joint, 0.005, force=force, learn=learn), bank


@pytest.mark.parametrize("learn", [False, True])
@pytest.mark.parametrize("force", [False, True])
def test_exact_without_noise(force: bool, learn: bool) -> None:
    fresh, _ = fitted(0.0, FORCE_M if force else 0.0, force=force, learn=learn)
    wanted = [A, B, FORCE_M][: fresh.parts]
    assert fresh.mean[:, : fresh.parts] == pytest.approx(np.tile(wanted, (10, 1)), abs=2e-8)
    assert np.all(fresh.gain > 0.0)


@pytest.mark.slow
def test_its_covariance_is_that_of_its_errors() -> None:
    """Two hundred draws: mean normalised error squared of two numbers, 2."""
    squares = []
    for seed in range(200):
        fresh, _ = fitted(IMAGE_M, 0.0, force=False, learn=False, seed=seed)
        off = fresh.mean[0, :2] - (A, B)
        squares.append(off @ np.linalg.solve(fresh.covariance[0, :2, :2], off))
    assert 1.4 < float(np.mean(squares)) < 2.7


def test_a_force_is_no_free_vibration() -> None:
    free, _ = fitted(IMAGE_M, FORCE_M, force=False, learn=True)
    forced, _ = fitted(IMAGE_M, FORCE_M, force=True, learn=True)
    assert free.misfit[0] > 50.0
    assert forced.misfit[0] < 2.0


def test_images_alone_tell_no_date() -> None:
    """Phase and date go together: the shift keeps its deviation, and the phasor gets it."""
    fresh, bank = fitted(IMAGE_M, 0.0, force=False, learn=True)
    place = fresh.states.index(AT.shift)
    assert fresh.covariance[0, place, place] == pytest.approx(bank.p[0, AT.shift, AT.shift], rel=0.02)


def test_the_bank_takes_it_and_stays_a_covariance() -> None:
    fresh, bank = fitted(IMAGE_M, FORCE_M, force=True, learn=True)
    start_vibration(bank, fresh.states, fresh.mean, fresh.covariance, fresh.parts)
    assert bank.x[0, :2] == pytest.approx([A, B], abs=5 * IMAGE_M)
    assert bank.x[0, AT.force] == pytest.approx(FORCE_M, abs=5 * IMAGE_M)
    assert np.all(bank.x[5:, AT.force] == 0.0)
    assert np.linalg.eigvalsh(bank.p).min() > -1e-12
    assert bank.p == pytest.approx(bank.p.transpose(0, 2, 1), abs=1e-15)


def test_too_few_images_give_no_window() -> None:
    images = HeldImages()
    for k in range(7):
        images.add(np.full(LAWS, k * FRAME_S), 0.0, 1.0, 1.0)
    assert images.newest(1.0, 0, 0.1) is None
