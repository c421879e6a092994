"""A step of the arrivals beside a delay that wanders."""

import numpy as np
import pytest
from scipy.signal import lfilter

from stillarm.diagnosis.data.frame_times import arrival_step
from stillarm.diagnosis.data.noise import wander_colour

FRAMES, AT = 1500, 900


def late(seed: int, step_s: float) -> np.ndarray:
    """Arrivals, s, of a delay that wanders by 5 ms over 40 frames and scatters by 2 ms, with a step."""
    random = np.random.default_rng(seed)
    stay = 1.0 - 1.0 / 40.0
    wander = lfilter([5e-3 * np.sqrt(1.0 - stay**2)], [1.0, -stay], random.standard_normal(FRAMES + 400))[
        400:
    ]
    found: np.ndarray = wander + 2e-3 * random.standard_normal(FRAMES) + step_s * (np.arange(FRAMES) >= AT)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_a_step_is_found_where_it_is(seed: int) -> None:
    arrived = late(seed, 0.02)
    arrived[::50] = np.nan
    step = arrival_step(arrived, 450.0)
    assert step is not None
    assert abs(step.index - AT) <= 1 and step.step_s == pytest.approx(0.02, abs=6e-3)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_a_wander_alone_is_no_step(seed: int) -> None:
    assert arrival_step(late(seed, 0.0), 450.0) is None


def test_the_law_learnt_without_the_step_is_a_quicker_wander() -> None:
    without, with_step = wander_colour(late(1, 0.0), 450.0), wander_colour(late(1, 0.02), 450.0)
    assert with_step != without


def test_too_few_frames_show_none() -> None:
    assert arrival_step(late(1, 0.02)[:50], 450.0) is None
