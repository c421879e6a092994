"""Delays drawn from the law itself, apart from what solves for it: the deviations stated hold."""

import numpy as np
import pytest
from numpy.typing import NDArray

from stillarm.diagnosis.calibration.delay_spread import delay_spread

PERIOD_S, STD_S = 1.0 / 65.0, 0.0064


def delays(seed: int, time_s: float, duration_s: float, share: float) -> NDArray[np.float64]:
    """Wander of the first order and white noise, of unit mean in units of 74 ms."""
    random = np.random.default_rng(seed)
    n = round(duration_s / PERIOD_S)
    stay = np.exp(-PERIOD_S / time_s)
    wander = np.empty(n)
    wander[0] = random.standard_normal()
    for k, step in enumerate(random.standard_normal(n - 1), start=1):
        wander[k] = stay * wander[k - 1] + np.sqrt(1.0 - stay**2) * step
    white = random.standard_normal(n)
    late: NDArray[np.float64] = 0.074 + STD_S * (np.sqrt(share) * wander + np.sqrt(1.0 - share) * white)
    return late


@pytest.mark.slow
@pytest.mark.parametrize(("time_s", "share"), [(2.0, 0.9), (10.0, 0.9), (1.0, 0.0)])
def test_mean_and_spread_lie_within_what_is_stated(time_s: float, share: float) -> None:
    """Over many recordings: within three deviations in at least 95 of 100, and the deviations are no mere excuse."""
    errors = []
    for seed in range(40):
        late = delays(seed, time_s, 40.0, share)
        found = delay_spread(late, PERIOD_S, 40.0)
        errors.append(
            ((found.std_s - STD_S) / found.std_of_std_s, (float(late.mean()) - 0.074) / found.mean_std_s)
        )
    sizes = np.abs(np.array(errors))
    assert np.mean(sizes < 3.0, axis=0).min() >= 0.95
    assert np.sqrt(np.mean(sizes**2, axis=0)).min() > 0.2


def test_a_white_delay_is_known_well() -> None:
    found = delay_spread(delays(1, 1.0, 60.0, 0.0), PERIOD_S, 60.0)
    assert found.std_s == pytest.approx(STD_S, rel=0.05)
    assert found.std_of_std_s < 0.05 * STD_S and found.mean_std_s < 0.0005


def test_missing_frames_and_single_outliers_do_not_matter() -> None:
    late = delays(2, 1.0, 60.0, 0.0)
    late[100::50] = np.nan
    late[77] = 3.0
    assert delay_spread(late, PERIOD_S, 60.0).std_s == pytest.approx(STD_S, rel=0.07)
