"""The recorded images of a run: found without a clock, drawn with the points of the tracker, served by their time."""

import json
import struct
from pathlib import Path

import msgspec
import numpy as np
import pytest

from stillarm.common.user_error import UserError
from stillarm.panel.live.view import VIEW_KIND
from stillarm.panel.recordings.extract import extract
from stillarm.panel.recordings.images import nearest_siblings, write_views
from stillarm.panel.recordings.view_files import has_views, view_at
from tests.fixtures.recordings import some_fast, written
from tests.fixtures.tracked_images import COUNT, PERIOD_S, READ_LATER_S, SHAPE, frames_of, tracked_images


def head_of(message: bytes) -> dict[str, object]:
    (length,) = struct.unpack_from("<H", message, 2)
    return dict(msgspec.json.decode(message[4 : 4 + length]))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    images = tracked_images()
    folder = tmp_path / "recordings"
    folder.mkdir()
    (folder / "run.mcap").write_bytes(written([*some_fast(10), *frames_of(images)]))
    (folder / "images.mcap").write_bytes(written([("/images", one) for one in images]))
    (folder / "broken.mcap").write_bytes(b"no recording")
    return folder


def test_a_runs_images_are_found_in_the_supervisors_file_and_told_on_the_controllers_clock(
    folder: Path, tmp_path: Path
) -> None:
    run, out = folder / "run.mcap", tmp_path / "out"
    assert write_views(run, list(nearest_siblings(run, folder)), out) == COUNT - 1
    third = view_at(out, READ_LATER_S + 3.5 * PERIOD_S)
    assert third.time_s == pytest.approx(READ_LATER_S + 3 * PERIOD_S)
    assert third.until_s == pytest.approx(READ_LATER_S + 4 * PERIOD_S)
    assert third.message[0] == VIEW_KIND
    head = head_of(third.message)
    assert (head["frame"], head["width_px"], head["height_px"]) == (3, SHAPE[1], SHAPE[0])
    points = head["points"]
    assert isinstance(points, list) and len(points) > 10
    assert all(0.0 <= x < SHAPE[1] and 0.0 <= y < SHAPE[0] for x, y in points)


def test_the_points_follow_the_scene(folder: Path, tmp_path: Path) -> None:
    images = tracked_images()
    write_views(folder / "images.mcap", [], tmp_path / "out")
    first, last = (view_at(tmp_path / "out", one.time_s) for one in (images[0], images[-1]))
    firsts, lasts = (head_of(view.message)["points"] for view in (first, last))
    assert isinstance(firsts, list) and isinstance(lasts, list)
    moved = lasts[0][0] - firsts[0][0]  # the first feature stays in view
    assert moved == pytest.approx(images[-1].displacement_px, abs=0.2)
    assert abs(moved) > 2.0


def test_images_of_another_run_are_not_taken(folder: Path, tmp_path: Path) -> None:
    others = [msgspec.structs.replace(one, started_cycle=one.started_cycle + 7) for one in tracked_images()]
    (folder / "images.mcap").write_bytes(written([("/images", one) for one in others]))
    run = folder / "run.mcap"
    with pytest.raises(UserError, match=r"no images of this run in the folder; .*--record-images"):
        write_views(run, list(nearest_siblings(run, folder)), tmp_path / "out")
    assert not has_views(tmp_path / "out")


def test_the_supervisors_own_file_is_drawn_by_its_displacement(folder: Path, tmp_path: Path) -> None:
    images = tracked_images()
    extract(folder / "images.mcap", tmp_path / "out")
    about = json.loads((tmp_path / "out" / "about.json").read_text())
    assert list(about["topics"]) == ["frames"] and about["end_s"] == images[-1].time_s
    rows = np.load(tmp_path / "out" / "frames.npy")
    assert rows[1].tolist() == [one.displacement_px for one in images]
