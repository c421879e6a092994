"""The delay that the filters' mixture tells, and how late images come in the mean."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS
from stillarm.controller.estimation.fused.fusion.image_delay import ImageDelay

FRAME_S, CYCLE_S = 1 / 65, 0.001


def told(
    weights: list[float], delays: list[float], variances: list[float], times: int = 1
) -> tuple[Any, Any]:
    """The state, and how late images come, after some images of the same kind."""
    state: Any = SimpleNamespace(
        assumed=ASSUMPTIONS,
        delay_s=0.07,
        delay_std_s=0.03,
        frame_s=FRAME_S,
        sampled_s=0.4 * CYCLE_S,
        evidence=SimpleNamespace(weights=np.array(weights)),
    )
    delay = ImageDelay(state)
    for _ in range(times):
        delay.tell(np.array(delays), np.array(variances))
    return state, delay


def test_the_mixture_has_mean_and_variance_of_all_filters() -> None:
    """0.4 of a cycle more: when within it a sensor was sampled nobody knows."""
    state, _ = told([0.25, 0.75], [0.070, 0.074], [1e-6, 4e-6])
    assert state.delay_s == pytest.approx(0.073)
    variance = 0.25 * (1e-6 + 0.003**2) + 0.75 * (4e-6 + 0.001**2) + (0.4 * CYCLE_S) ** 2
    assert state.delay_std_s == pytest.approx(variance**0.5)


def test_only_delays_that_are_known_teach_how_late_images_come() -> None:
    _, unknown = told([1.0], [0.09], [0.01**2], times=300)
    assert unknown.mean_s == 0.07
    _, known = told([1.0], [0.09], [0.001**2], times=300)
    assert known.mean_s == pytest.approx(0.09, abs=1e-4)
    assert known.variance**0.5 == pytest.approx(0.001, abs=2e-3)
