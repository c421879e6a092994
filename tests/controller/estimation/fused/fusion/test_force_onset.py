"""When a force may begin: of which filters it is asked whether the image's zero is known."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS
from stillarm.controller.estimation.fused.filters.jumps import loosen
from stillarm.controller.estimation.fused.filters.laws import DISTURBED, FILTERS, LAWS, QUIET
from stillarm.controller.estimation.fused.fusion.force_onset import begin_force
from stillarm.controller.estimation.fused.learning.held_force import HeldForce, SlowPull
from stillarm.controller.estimation.fused.recovery.consistency import Consistency
from tests.fixtures.ringing_bank import IMAGE_M2, bank

HELD_M = 0.27


def knowing(zero_std_m: float, best: int) -> Any:
    """A state whose filters know zero and scale, with the joint at 0.27 m, and of which `best` is the likeliest."""
    filters, at = bank()
    filters.p[:, at.offset, at.offset] = zero_std_m**2
    filters.p[:, at.scale, at.scale] = 1e-8
    weights = np.full(FILTERS, 0.05)
    weights[best] = 0.55
    return SimpleNamespace(
        bank=filters, at=at, assumed=ASSUMPTIONS, image_m2=IMAGE_M2, held_m=HELD_M, shaken=False,
        held_force=HeldForce(at.modes, IMAGE_M2, 0.4), slow_pull=SlowPull(12.0),
        evidence=SimpleNamespace(weights=weights, best=best), amplitude_m=0.0, consistency=Consistency(),
    )  # fmt: skip


@pytest.mark.parametrize("best", [0, LAWS + 4])
def test_a_force_may_begin_though_the_disturbed_filters_have_been_loosened(best: int) -> None:
    """Their scale may be off by a tenth then, which is 27 mm of the zero where the joint holds the tip 0.27 m out.
    Asked of them, a pull of an arm whose vibration they had followed was refused for 0.3 s."""
    state = knowing(2e-5, best)
    loosen(state.bank, DISTURBED)
    assert begin_force(state, 1.0, 0.001)
    assert state.held_force.active
    assert state.bank.zero_variance(best, HELD_M) < IMAGE_M2 or best >= LAWS


def test_no_force_begins_before_the_zero_is_known() -> None:
    for best in (0, LAWS + 4):
        assert not begin_force(knowing(1e-4, best), 1.0, 0.001)
    loose = knowing(2e-5, 0)
    loosen(loose.bank, QUIET)
    assert not begin_force(loose, 1.0, 0.001)


def test_images_of_a_vibration_that_was_never_followed_show_wrong_dates_and_no_force() -> None:
    """A queue that drained at the start: the images left their gates by 0.7 of the amplitude."""
    state = knowing(2e-5, 0)
    state.amplitude_m = 0.006
    assert not begin_force(state, 1.0, 0.004)
    for frame in range(60):
        state.consistency.see(frame / 65.0, 1.0, 0.0, 1e-5, 0.07)
    assert begin_force(state, 1.0, 0.004)


@pytest.mark.parametrize(("amplitude_m", "size_m"), [(0.0, 0.004), (0.0015, 0.004)])
def test_a_pull_of_an_arm_at_rest_is_a_force_from_the_first(amplitude_m: float, size_m: float) -> None:
    state = knowing(2e-5, 0)
    state.amplitude_m = amplitude_m
    assert begin_force(state, 1.0, size_m)
