"""Single impulses, Poisson, of either sign."""

import numpy as np
import pytest

from stillarm.common.files.model import Model
from stillarm.simulation.sensors.accelerometer_effects import AccelerometerEffects
from tests.fixtures.felt import CYCLE_S, TIMES, sensed


@pytest.mark.slow
def test_impulses_are_single_poisson_and_of_either_sign() -> None:
    """Count, spacing and signs over 400 runs of four seconds, as a Poisson process has them."""
    effect = {"cause": "impulse_noise", "rate_hz": 2.0, "amplitude_m_s2": 8.0}
    counts, gaps, ups = [], [], 0
    for seed in range(400):
        model = Model(effects=[effect])  # type: ignore[list-item]
        effects = AccelerometerEffects(model, CYCLE_S, seed)
        added = np.array([effects.added_m_s2(t, 0.0) for t in TIMES.tolist()])
        assert set(np.round(added[added != 0.0], 9)) <= {8.0, -8.0, 16.0, -16.0}
        at = np.flatnonzero(added)
        counts.append(len(at))
        gaps += np.diff(at).tolist()
        ups += int(np.sum(added > 0.0))
    total = sum(counts)
    assert np.mean(counts) == pytest.approx(8.0, abs=4.0 * (8.0 / 400) ** 0.5)
    assert np.var(counts) == pytest.approx(8.0, rel=0.3)
    assert ups / total == pytest.approx(0.5, abs=4.0 * 0.5 / total**0.5)
    short = float(np.mean(np.array(gaps) < 100))
    # of two instants within one run, uniform over 4 s, gaps below 0.1 s: about 1 - exp(-0.2), a little more
    assert 0.15 < short < 0.25
    assert np.array_equal(sensed(effect, seed=3), sensed(effect, seed=3))
    assert not np.array_equal(sensed(effect, seed=3), sensed(effect, seed=4))
