"""No sample exceeds the range."""

import numpy as np
import pytest

from tests.fixtures.felt import PLAIN, sensed


def test_it_is_what_the_catalogue_says() -> None:
    effect = {"cause": "accelerometer_clipping", "range_m_s2": 1.3}
    assert sensed(effect) == pytest.approx(np.clip(PLAIN, -1.3, 1.3), abs=1e-12)
