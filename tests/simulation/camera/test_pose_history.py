"""The ring of poses: exact at its rows, linear between them, and honest about what it does not hold."""

import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.user_error import UserError
from stillarm.simulation.camera.pose_history import PoseHistory, PoseNoLonger, PoseNotYet


def _filled(rows: int, start_s: float = 10.0) -> PoseHistory:
    history = PoseHistory(None)
    for row in range(rows):
        time_s = start_s + 0.001 * row
        history.append(time_s, 3.0 * time_s, -2.0 * time_s)
    return history


@settings(max_examples=60, deadline=None)
@given(
    rows=st.integers(2, 9000),
    fractions=st.lists(st.floats(0.0, 1.0), min_size=1, max_size=20),
)
def test_a_straight_line_comes_back_exactly_wherever_the_ring_stands(
    rows: int, fractions: list[float]
) -> None:
    history = _filled(rows)
    newest = 10.0 + 0.001 * (rows - 1)
    held = min(rows - 1, 4000) * 0.001
    times = np.clip(newest - held * np.array(fractions), 10.0, newest)
    positions, angles = history.interpolate(times)
    np.testing.assert_allclose(positions, 3.0 * times, rtol=1e-12)
    np.testing.assert_allclose(angles, -2.0 * times, rtol=1e-12)


def test_the_shape_of_the_times_is_kept() -> None:
    positions, angles = _filled(100).interpolate(np.full((4, 3), 10.05))
    assert positions.shape == angles.shape == (4, 3)


def test_a_vibration_is_off_by_less_than_a_thousandth_of_a_pixel() -> None:
    history, w, amplitude = PoseHistory(None), 2.0 * np.pi * 2.6, 0.00625
    for row in range(1000):
        history.append(0.001 * row, amplitude * float(np.sin(w * 0.001 * row)), 0.0)
    times = np.linspace(0.0, 0.99, 7777)
    positions, _ = history.interpolate(times)
    assert 800.0 * np.abs(positions - amplitude * np.sin(w * times)).max() < 1e-3


def test_poses_not_yet_or_no_longer_there_are_refused() -> None:
    history = _filled(6000)
    with pytest.raises(PoseNotYet):
        history.interpolate(np.array([15.0, 15.9991]))
    with pytest.raises(PoseNoLonger):
        history.interpolate(np.array([11.0, 15.0]))
    with pytest.raises(PoseNotYet):
        PoseHistory(None).interpolate(np.array([0.0]))
    assert PoseHistory(None).newest_time_s() == float("-inf")


def test_at_least_two_seconds_are_held() -> None:
    positions, _ = _filled(50_000).interpolate(np.array([59.999 - 2.048]))
    assert positions[0] == pytest.approx(3.0 * 57.951, rel=1e-12)


def test_rows_overwritten_while_they_are_copied_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    history = _filled(5000)
    copy = PoseHistory._copy

    def slow_copy(self: PoseHistory, begin: int, end: int) -> np.ndarray:
        rows = copy(self, begin, end)
        for row in range(100):
            self.append(20.0 + row, 0.0, 0.0)
        return rows

    monkeypatch.setattr(PoseHistory, "_copy", slow_copy)
    with pytest.raises(PoseNoLonger, match="overwritten"):
        history.interpolate(np.array([10.91, 10.92]))


def test_writer_and_reader_share_a_ring_and_a_restart_is_seen() -> None:
    name = f"test-pose-{os.getpid()}"
    with pytest.raises(UserError):
        PoseHistory(name)
    writer = PoseHistory(name, create=True)
    reader = PoseHistory(name)
    writer.append(1.0, 0.25, 0.5)
    writer.append(2.0, 0.75, 0.5)
    assert reader.newest_time_s() == 2.0
    positions, angles = reader.interpolate(np.array([1.5]))
    assert (positions[0], angles[0]) == (0.5, 0.5)
    assert not reader.replaced()
    restarted = PoseHistory(name, create=True)
    assert reader.replaced()
    for history in (writer, reader, restarted, restarted):
        history.close()


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32), rows=st.integers(2, 6000))
def test_rows_at_irregular_times_are_found_as_well(seed: int, rows: int) -> None:
    random = np.random.default_rng(seed)
    times = 5.0 + np.cumsum(random.exponential(0.001, rows) * (1.0 + 200.0 * (random.random(rows) < 0.01)))
    values = random.standard_normal(rows)
    history = PoseHistory(None)
    for time_s, value in zip(times.tolist(), values.tolist(), strict=True):
        history.append(time_s, value, -value)
    held_from = times[max(0, rows - 4000)]
    for _ in range(20):
        asked = np.sort(random.uniform(held_from, times[-1], 3))
        positions, angles = history.interpolate(asked)
        np.testing.assert_allclose(positions, np.interp(asked, times, values), rtol=0, atol=1e-9)
        np.testing.assert_allclose(angles, -positions, rtol=0, atol=1e-12)
