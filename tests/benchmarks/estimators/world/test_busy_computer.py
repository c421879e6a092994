"""Images that a busy computer delivers."""

import numpy as np
import pytest

from stillarm.benchmarks.estimators.world.generator import expose
from stillarm.benchmarks.estimators.world.regimes import FRAME_S, REGIMES, Busy

LIVE = REGIMES["live"]

BUSY = LIVE.busy or Busy()


def test_a_busy_computer_is_behind_at_first_and_late_on_one_side_ever_after() -> None:
    """The initial queue drains. Then delays have a hard minimum, the stated mean and a tail; n_i is the end
    of an earlier image.
    """
    late, first, means, lost = [], [], [], 0
    for seed in range(30):
        frames = expose(LIVE, 40.0, np.random.default_rng(seed))
        delay = frames.delay_s
        assert np.all(np.diff(frames.read_cycle) >= 0)
        assert delay.min() >= BUSY.earliest_s + BUSY.service_s
        first.append(delay[:8].mean())
        means.append(np.median(delay[80:]))
        late.append(delay[80:] - np.median(delay[80:]))
        lost += int(np.sum(np.diff(frames.number) - 1))
        begun = frames.started_cycle[BUSY.in_flight :]
        ended = frames.read_cycle[: -BUSY.in_flight]
        assert np.all((ended - begun >= 0) & (ended - begun <= 1))
        assert np.diff(frames.exposed_s) / np.diff(frames.number) == pytest.approx(FRAME_S, rel=2e-4)
    assert np.mean(np.array(first) > np.array(means) + 0.01) > 0.9
    assert 0.115 < np.mean(first) < 0.16
    assert np.mean(means) == pytest.approx(LIVE.delay_s, abs=0.003)
    assert np.std(means) == pytest.approx(BUSY.mean_std_s, rel=0.45)
    together = np.concatenate(late)
    assert np.quantile(together, 0.999) > 3.0 * -np.quantile(together, 0.001)
    assert lost < 200
