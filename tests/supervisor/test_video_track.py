"""Videos with a known motion, and the shared ones where they are."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from stillarm.common.files.configuration import Tracker
from stillarm.common.user_error import UserError
from stillarm.supervisor.video_track import (
    COLUMNS,
    Region,
    csv_row,
    main_frequency_hz,
    stated_frames,
    stated_rate_hz,
    summary,
    tracked,
)
from stillarm.tables.readers.read_file import read_table_file
from tests.fixtures.camera_files import write_raw
from tests.fixtures.sinusoid_scene import SinusoidScene, photographed

DATA = Path(__file__).parents[3] / "shared" / "data"
FRAMES, HZ, RATE_HZ = 100, 7.3, 100.0
MOVED = 1.5 * np.sin(2.0 * np.pi * HZ * np.arange(FRAMES) / RATE_HZ)
shared = pytest.mark.skipif(not DATA.is_dir(), reason="../shared/data is not there")


def images() -> list[NDArray[np.uint8]]:
    scene, random = SinusoidScene(1), np.random.default_rng(0)
    return [photographed(scene.at(float(x), 0.0, shape=(96, 128)), random) for x in MOVED]


def folder_of_images(path: Path) -> Path:
    path.mkdir()
    for number, image in enumerate(images()):
        cv2.imwrite(str(path / f"frame{number}.png"), image)
    return path


def video(path: Path) -> Path:
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 25.0, (128, 96))
    for image in images():
        writer.write(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR))
    writer.release()
    return path


@pytest.mark.slow
def test_a_folder_of_images_gives_the_motion(tmp_path: Path) -> None:
    path = folder_of_images(tmp_path / "images")
    samples = list(tracked(path, Tracker(), None))
    assert [sample.frame for sample in samples] == list(range(FRAMES))
    moved = np.array([sample.displacement_x_px for sample in samples])
    assert np.nanstd(moved - (MOVED - MOVED[0])) < 0.03
    told = summary(samples, RATE_HZ)
    assert (told.frames, told.measured, told.axis) == (FRAMES, FRAMES, "x")
    assert abs(told.frequency_hz - HZ) < 0.05 and abs(told.span_px - 3.0) < 0.1
    assert stated_rate_hz(path) is None and stated_frames(path) == FRAMES


@pytest.mark.slow
def test_a_video_says_its_rate_and_a_part_of_it_moves_alike(tmp_path: Path) -> None:
    path = video(tmp_path / "moved.avi")
    assert stated_rate_hz(path) == pytest.approx(25.0) and stated_frames(path) == FRAMES
    samples = list(tracked(path, Tracker(), Region(16, 8, 96, 80)))
    moved = np.array([sample.displacement_x_px for sample in samples])
    assert np.nanstd(moved - (MOVED - MOVED[0])) < 0.1


def test_raw_video_plays_with_its_own_rate(tmp_path: Path) -> None:
    path = write_raw(tmp_path, np.stack(images()[:8]), 8, 8, "Lower")
    assert stated_rate_hz(path) == stated_rate_hz(path.with_suffix(".mraw")) == 10_000.0
    assert len(list(tracked(path, Tracker(), None))) == stated_frames(path) == 8


def test_a_reduced_image_moves_by_as_many_px_of_the_whole_one(tmp_path: Path) -> None:
    large = [cv2.resize(image, (256, 192), interpolation=cv2.INTER_CUBIC) for image in images()[:12]]
    path = write_raw(tmp_path, np.stack(large), 8, 8, "Lower")
    moved = np.array([s.displacement_x_px for s in tracked(path, Tracker(), None, shrink=2)])
    assert np.max(np.abs(moved - 2.0 * (MOVED[:12] - MOVED[0]))) < 0.2


def test_a_region_beyond_the_image_is_refused(tmp_path: Path) -> None:
    path = write_raw(tmp_path, np.stack(images()[:2]), 8, 8, "Lower")
    with pytest.raises(UserError, match="128 x 96 px"):
        list(tracked(path, Tracker(), Region(100, 0, 40, 40)))


def test_the_rows_are_the_visual_channel_of_a_bundle(tmp_path: Path) -> None:
    path = write_raw(tmp_path, np.stack(images()[:3]), 8, 8, "Lower")
    rows = [csv_row(sample, 200.0) for sample in tracked(path, Tracker(), None)]
    (tmp_path / "frames.csv").write_text("\n".join([COLUMNS, *rows, "3,0.015,,0.015,0,0,,,,,,2"]) + "\n")
    (table,) = read_table_file(tmp_path / "frames.csv").tables
    assert list(table.columns) == COLUMNS.split(",")
    np.testing.assert_allclose(table.columns["received_s"], [0.0, 0.005, 0.01, 0.015])
    assert (
        np.isnan(table.columns["displacement_px"][3])
        and not np.isnan(table.columns["displacement_px"][:3]).any()
    )


@pytest.mark.parametrize("hz", [3.21, 17.77, 40.4])
def test_the_main_frequency_of_a_sine_with_gaps(hz: float) -> None:
    moved = np.sin(2.0 * np.pi * hz * np.arange(300) / RATE_HZ)
    moved[[17, 18, 100]] = np.nan
    assert abs(main_frequency_hz(moved, RATE_HZ) - hz) < 0.02
    assert np.isnan(main_frequency_hz(moved[:20], RATE_HZ)) and np.isnan(main_frequency_hz(np.zeros(99), 1.0))


@shared
@pytest.mark.slow
@pytest.mark.hardware_data
def test_the_tuning_fork_vibrates_as_it_was_driven() -> None:
    """Driven at 32 Hz, filmed at 250 frames/s, played at 50. One prong's head; 888 frames resolve 0.28 Hz."""
    path = DATA / "tuning_fork_video" / "tuning_hz32_fps250_50-1_640x420.mp4"
    assert stated_rate_hz(path) == pytest.approx(50.0, rel=1e-3)
    config = Tracker(window_px=11, min_inliers=6)
    told = summary(list(tracked(path, config, Region(355, 70, 48, 75))), 250.0)
    assert told.measured > 0.98 * told.frames and told.axis == "x"
    assert abs(told.frequency_hz - 32.0) < 0.15


@shared
@pytest.mark.slow
@pytest.mark.hardware_data
def test_the_phones_camera_is_late_by_the_known_delay() -> None:
    """Image rotation rate against the rotation sensor's: known lag about 0.47 s, correlation 0.96."""
    folder = DATA / "phone_rotation"
    samples = list(tracked(folder / "VID_20150409_162802.mp4", Tracker(), None, shrink=4))
    turned = np.array([sample.rotation_rad for sample in samples])
    rate, middle_s = np.diff(turned) * 15.0, (np.arange(1, len(turned)) - 0.5) / 15.0
    seen = np.isfinite(rate)
    assert seen.sum() > 0.6 * len(samples)
    (table,) = read_table_file(folder / "VID_20150409_162802.txt").tables
    columns = np.stack([np.asarray(values, dtype=np.float64) for values in table.columns.values()])
    matrices = columns[2:].T.reshape(-1, 3, 3)
    # R(n)^T R(n+1) is the turn between two samples; its (1, 0) entry is the small angle about the optical axis
    between = np.einsum("nji,njk->nik", matrices[:-1], matrices[1:])
    spin = np.convolve(between[:, 1, 0] / (np.diff(columns[1]) * 1e-9), np.ones(13) / 13.0, "same")
    begun_ms = float((folder / "VID_20150409_162802.txt").read_text().splitlines()[0])
    time_s = (columns[0][0] - begun_ms) * 1e-3 + (columns[1][1:] - columns[1][0]) * 1e-9
    lags = np.arange(0.0, 1.0, 0.01)
    match = [
        abs(np.corrcoef(np.interp(middle_s[seen] + lag, time_s, spin), rate[seen])[0, 1]) for lag in lags
    ]
    assert max(match) > 0.95 and abs(lags[int(np.argmax(match))] - 0.47) < 0.03
