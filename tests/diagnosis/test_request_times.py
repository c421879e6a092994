"""Requests off their interval."""

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.request_times import request_intervals
from tests.diagnosis.synthetic import measured


def test_a_clock_that_was_set_stands_out_of_the_requests_intervals() -> None:
    """By the step, at the request after it, over no less than a cycle."""
    data = measured(4.0, 1, {})
    started = 0.015 * np.arange(len(data.frames))
    started[100:] += 0.08
    found = request_intervals(replace(data, frames=replace(data.frames, started_s=started)))
    assert int(np.argmax(np.abs(found.off_s))) == 99
    assert found.off_s[99] == pytest.approx(0.08)
    assert found.usual_s == pytest.approx(data.cycle_s)
