"""The demo's output folder: it removes no other files."""

from pathlib import Path

import pytest

from stillarm.common.user_error import UserError
from stillarm.simulation.demo.own_folder import own_folder
from stillarm.simulation.demo.set_up import write_demo_configuration


def test_an_earlier_demo_is_replaced(tmp_path: Path) -> None:
    """What it measured is removed; the same folder serves again."""
    with own_folder(tmp_path / "d"):
        write_demo_configuration(tmp_path / "d", 12.0, 0)
        (tmp_path / "d" / "recording.mcap").touch()
    with own_folder(tmp_path / "d"):
        assert not (tmp_path / "d" / "recording.mcap").exists()


@pytest.mark.parametrize("name", ["model.toml", "config.toml", "recording.mcap"])
def test_files_of_somebody_else_s_are_kept(tmp_path: Path, name: str) -> None:
    """`stillarm demo --out .` beside one's own model file."""
    (tmp_path / name).write_text("mine")
    with pytest.raises(UserError, match=f"{name} in it is not a demo's"), own_folder(tmp_path):
        pytest.fail("entered")
    assert (tmp_path / name).read_text() == "mine"


def test_two_demos_at_once_do_not_share_a_folder(tmp_path: Path) -> None:
    """Neither the files nor the processes of the first are touched; afterwards the folder is free again."""
    with own_folder(tmp_path), pytest.raises(UserError, match="another demo runs"), own_folder(tmp_path):
        pytest.fail("entered twice")
    with own_folder(tmp_path):
        pass
