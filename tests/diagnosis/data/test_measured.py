"""Recorded rows on the grid: gaps, clocks that step back, columns that were not recorded."""

from pathlib import Path

import numpy as np
import pytest

from stillarm.common.files.model import Arm, Model
from stillarm.common.recording.reader import open_recording
from stillarm.common.user_error import UserError
from stillarm.diagnosis.data.measured import Measured, reclocked
from stillarm.diagnosis.data.reading import read_measured
from stillarm.diagnosis.diagnose import model_of
from stillarm.main import main

MODEL = Model(arm=Arm(length_m=2.0))


def read(folder: Path, time_s: np.ndarray, **columns: np.ndarray) -> Measured:
    """By way of a bundle, as a user's data come."""
    bundle = folder / "bundle"
    bundle.mkdir()
    columns = {"acceleration_m_s2": np.arange(len(time_s), dtype=float)} | columns
    head = ",".join(["time_s", *columns])
    rows = [",".join(f"{value:.9g}" for value in row) for row in zip(time_s, *columns.values(), strict=True)]
    (bundle / "fast.csv").write_text("\n".join([head, *rows]) + "\n")
    (bundle / "model.toml").write_text("[arm]\nlength_m = 2.0\n")
    assert main(["import", str(bundle), "-o", str(folder / "r.mcap")]) == 0
    recording = open_recording(folder / "r.mcap")
    return read_measured(recording, model_of(recording))


def test_missing_rows_are_missing_samples_and_a_gap(tmp_path: Path) -> None:
    time = np.delete(5.0 + np.arange(4000) * 0.001, slice(1500, 1750))
    found = read(tmp_path, time)
    assert found.cycles == 4000
    assert found.origin_s == pytest.approx(5.0)
    assert np.isnan(found.acceleration[1500:1750]).all()
    assert found.acceleration[1750] == 1500.0
    assert [(gap.cycle, round(gap.extra_s, 6)) for gap in found.gaps] == [(1750, 0.25)]


@pytest.mark.parametrize(("missed", "gaps"), [(250, 0), (249, 1)])
def test_cycles_that_the_loop_says_it_missed_are_no_clock_that_was_set(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, missed: int, gaps: int
) -> None:
    read(tmp_path, np.delete(np.arange(4000) * 0.001, slice(1500, 1750)))
    recording = open_recording(tmp_path / "r.mcap")
    columns, told = recording.columns, {"deadline_misses": np.array([0, missed])}
    monkeypatch.setattr(recording, "counts", recording.counts | {"/link": 2})
    monkeypatch.setattr(recording, "columns", lambda topic: told if topic == "/link" else columns(topic))
    assert len(read_measured(recording, MODEL).gaps) == gaps


def test_a_clock_that_steps_back_is_taken_forward_again(tmp_path: Path) -> None:
    time = np.arange(4000) * 0.001
    time[2000:] -= 0.3
    found = read(tmp_path, time)
    assert found.cycles == 4000
    assert np.isfinite(found.acceleration).all()
    assert [(gap.cycle, round(gap.extra_s, 6)) for gap in found.backward] == [(2000, -0.3)]


def test_a_gap_that_was_a_clock_set_forward_can_be_closed(tmp_path: Path) -> None:
    time = np.arange(4000) * 0.001
    time[2000:] += 0.4
    found = read(tmp_path, time)
    assert found.cycles == 4400
    closed = reclocked(found, found.gaps[0])
    assert closed.cycles == 4000
    assert np.array_equal(closed.acceleration, np.arange(4000.0))
    assert closed.gaps == ()


def test_a_command_is_held_over_rows_without_one(tmp_path: Path) -> None:
    command = np.full(4000, 0.2)
    command[1000:1100] = np.nan
    found = read(tmp_path, np.arange(4000) * 0.001, joint_velocity_command_rad_s=command)
    assert np.all(found.command == 0.2)


def test_rows_too_far_apart_for_the_first_mode_are_refused(tmp_path: Path) -> None:
    time = np.arange(300) * 0.5
    with pytest.raises(
        UserError, match=r"rows come every 0\.5 s, too far apart .* correct the model's frequency"
    ):
        read(tmp_path, time)


@pytest.mark.slow
@pytest.mark.parametrize(("rate_hz", "digits"), [(100.0, 6), (610.3515625, 6), (2500.0, 5)])
def test_rows_at_another_rate_than_the_models_cycle_make_their_own_grid(
    tmp_path: Path, rate_hz: float, digits: int
) -> None:
    """No sample is lost, and none is invented between two; rounded times add up to no drift."""
    time = np.round(np.arange(5000) / rate_hz, digits)
    found = read(tmp_path, time)
    assert found.cycle_s == pytest.approx(1.0 / rate_hz, rel=1e-4)
    assert not found.backward and not found.gaps
    assert np.isfinite(found.acceleration).mean() > 0.999
    assert np.nanmax(found.acceleration) == 4999.0


def test_stamps_that_scatter_are_no_clock_that_was_set(tmp_path: Path) -> None:
    """A phone's sensor at about 200 Hz, stamped by a busy system's milliseconds."""
    scattered = np.round(np.random.default_rng(11).normal(0.0, 0.0015, 2000), 3)
    time = np.maximum.accumulate(np.arange(2000) * 0.005 + scattered) + 1e-6 * np.arange(2000)
    found = read(tmp_path, time)
    assert found.cycle_s == 0.001 and not found.backward


def test_rows_out_of_order_and_rows_twice_are_put_right(tmp_path: Path) -> None:
    order = np.arange(4000)
    order[[100, 101]] = 101, 100
    order = np.repeat(order, np.where(np.arange(4000) % 500 == 7, 2, 1))
    found = read(tmp_path, order * 0.001, acceleration_m_s2=order.astype(float))
    assert not found.backward and not found.gaps
    assert np.array_equal(found.acceleration, np.arange(4000.0))


@pytest.mark.slow
def test_a_command_goes_on_evenly_over_rows_that_are_missing(tmp_path: Path) -> None:
    """The drive was sent what was not written down: held, each missing row would leave the joint behind for good."""
    time = np.arange(4000) * 0.001
    command = 0.3 * np.sin(time)
    kept = np.delete(np.arange(4000), np.arange(50, 3950, 100))
    found = read(tmp_path, time[kept], joint_velocity_command_rad_s=command[kept])
    assert np.max(np.abs(found.command - command)) < 1e-6
