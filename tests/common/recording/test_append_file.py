"""A new recording may replace an earlier recording and no other file."""

from pathlib import Path

import pytest
from mcap.writer import MCAP0_MAGIC

from stillarm.common.recording.append_file import AppendFile
from stillarm.common.user_error import UserError


@pytest.mark.parametrize("content", [b"", MCAP0_MAGIC[:3], MCAP0_MAGIC + b"earlier"])
def test_an_earlier_recording_is_replaced_however_short_it_was_cut(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "rec.mcap"
    path.write_bytes(content)
    file = AppendFile(path)
    file.write(b"new")
    file.close()
    assert path.read_bytes() == b"new"


def test_any_other_file_is_kept(tmp_path: Path) -> None:
    """`stillarm import DIR -o DIR/fast.csv` must not cost the measured data."""
    path = tmp_path / "fast.csv"
    path.write_text("time_s\n0.0\n")
    with pytest.raises(UserError, match=r"fast\.csv: exists and is no recording") as refused:
        AppendFile(path)
    assert path.read_text() == "time_s\n0.0\n"
    assert "\n" not in str(refused.value)
