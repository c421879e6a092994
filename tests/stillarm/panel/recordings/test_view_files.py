"""Views on disk: each is found from its time to the next one's."""

from math import inf
from pathlib import Path

import pytest

from stillarm.common.user_error import UserError
from stillarm.panel.recordings.view_files import VIEWS, has_views, view_at, write_index


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two views, of 1 s and 2 s, written in the other order."""
    (tmp_path / VIEWS).write_bytes(b"second-first")
    write_index(tmp_path, [(2.0, 0, 6), (1.0, 7, 5)])
    return tmp_path


@pytest.mark.parametrize(
    ("time_s", "expected"),
    [
        (-9.0, (b"first", 1.0, 1.0)),  # before the first one, the first is shown
        (1.0, (b"first", 1.0, 2.0)),
        (1.9, (b"first", 1.0, 2.0)),
        (2.0, (b"second", 2.0, inf)),
        (99.0, (b"second", 2.0, inf)),
    ],
)
def test_the_newest_view_at_a_time(folder: Path, time_s: float, expected: tuple[bytes, float, float]) -> None:
    assert view_at(folder, time_s) == expected


def test_a_folder_without_views_says_so(tmp_path: Path) -> None:
    assert not has_views(tmp_path)
    with pytest.raises(UserError, match="have not been read yet"):
        view_at(tmp_path, 0.0)
    write_index(tmp_path, [])
    assert has_views(tmp_path)
    with pytest.raises(UserError, match="no image that can be drawn"):
        view_at(tmp_path, 0.0)
