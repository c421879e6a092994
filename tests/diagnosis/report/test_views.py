"""Views of what a report shows, at the edges of what a recording may be."""

import numpy as np

from stillarm.diagnosis.report.views import swing


def test_a_recording_shorter_than_two_periods_shows_no_swing() -> None:
    time = np.arange(0.0, 3.0, 0.05)
    found = swing(time, np.sin(2.0 * np.pi * 0.3 * time), 0.3)
    assert len(found.time_s) == len(found.amplitude) == len(found.frequency_hz)
    assert np.isnan(found.amplitude).all() and np.isnan(found.frequency_hz).all()


def test_a_longer_one_shows_its_frequency() -> None:
    time = np.arange(0.0, 30.0, 0.05)
    found = swing(time, np.sin(2.0 * np.pi * 0.31 * time), 0.3)
    assert abs(np.nanmedian(found.frequency_hz) - 0.31) < 1e-3
