"""Folders for results."""

from pathlib import Path

import pytest

from stillarm.common.files.output_folder import make_folder
from stillarm.common.user_error import UserError


def test_a_folder_is_made_with_those_above_it_and_taken_as_it_is(tmp_path: Path) -> None:
    assert make_folder(tmp_path / "a" / "b").is_dir()
    (tmp_path / "a" / "kept").touch()
    make_folder(tmp_path / "a")
    assert (tmp_path / "a" / "kept").exists()


@pytest.mark.parametrize("name", ["file", "file/below", "/proc/x"])
def test_what_cannot_be_a_folder_is_one_line(tmp_path: Path, name: str) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UserError, match="cannot be made a folder") as refused:
        make_folder(tmp_path / name)
    assert "\n" not in str(refused.value)
