"""Frames from files: images in natural order, videos, raw high-speed video of each depth, and what
goes wrong.
"""

import cv2
import numpy as np
import pytest

from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.file_camera import FileCamera
from tests.fixtures.camera_files import frames_of, write_raw


def test_video(tmp_path):
    path = tmp_path / "video.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 25, (64, 48))
    for level in (50, 100, 150):
        writer.write(np.full((48, 64, 3), level, np.uint8))
    writer.release()
    assert [round(float(f.image.mean()), -1) for f in frames_of(path)] == [50, 100, 150]


def test_errors_are_one_line_with_a_remedy(tmp_path):
    path = write_raw(tmp_path, np.zeros((2, 34, 36)), 8, 8, "Lower")
    text = path.read_text()
    (tmp_path / "empty").mkdir()
    (tmp_path / "bad.avi").write_bytes(b"not a video")
    cases = {
        tmp_path / "absent.avi": "no such file",
        tmp_path / "empty": "no readable frame",
        tmp_path / "bad.avi": "codec",
    }
    for case, part in cases.items():
        with pytest.raises(UserError, match=part) as error:
            FileCamera(case).start()
        assert "\n" not in str(error.value) and "give" in str(error.value)
    for old, new, part in (
        ("Total Frame : 2", "Total Frame : 5", "contains 2 of the 5 frames"),
        ("Color Bit : 8", "Color Bit : 24", "only mono with 8, 12 or 16 bit"),
        ("Image Width : 36", "Image Width : x", "Image Width = 'x': must be a positive integer"),
    ):
        path.write_text(text.replace(old, new))
        with pytest.raises(UserError, match=part) as error:
            FileCamera(path).start()
        assert "\n" not in str(error.value)
    path.write_text(text)
    (tmp_path / "v.mraw").unlink()
    with pytest.raises(UserError, match=r"needs its \.mraw"):
        FileCamera(path).start()


def test_folder_in_natural_order(tmp_path):
    for number in (1, 2, 10):
        cv2.imwrite(str(tmp_path / f"frame{number}.png"), np.full((40, 50), 10 * number, np.uint8))
    cv2.imwrite(str(tmp_path / "frame3.png"), np.full((40, 50, 3), 30, np.uint8))
    (tmp_path / "notes.txt").write_text("no image")
    found = frames_of(tmp_path)
    assert [int(f.image[0, 0]) for f in found] == [10, 20, 30, 100]
    assert [f.counter for f in found] == [0, 1, 2, 3]
    assert all(f.image.shape == (40, 50) and f.stamp_s is None for f in found)
