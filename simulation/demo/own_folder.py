"""The demo's output folder: it belongs to one demo at a time, and holds nothing but a demo's files."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stillarm.common.files.output_folder import make_folder
from stillarm.common.user_error import UserError

_WRITTEN = (
    "config.toml",
    "model.toml",
    "rig_model.toml",
    "scenario.toml",
    "recording.mcap",
    "truth.mcap",
    "summary.json",
)
_MARK = "memory:demo-"  # in the configuration of every demo: the name of its accelerometer's bus


@contextmanager
def own_folder(directory: Path) -> Iterator[None]:
    """Make the folder, and hold it for this demo alone; what an earlier demo measured is removed.

    Raises UserError when it holds files of somebody else's under the demo's names, or another demo runs in it.
    """
    make_folder(directory)
    held = os.open(directory, os.O_RDONLY | os.O_DIRECTORY)
    try:
        try:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise UserError(f"--out {directory}: another demo runs in it; name another folder") from None
        there = [name for name in _WRITTEN if (directory / name).exists()]
        if there and not _is_a_demos(directory):
            raise UserError(
                f"--out {directory}: {there[0]} in it is not a demo's and would be overwritten; "
                "name a folder of the demo's own"
            )
        for stale in ("recording.mcap", "truth.mcap", "summary.json", "rig_model.toml"):
            (directory / stale).unlink(missing_ok=True)
        yield
    finally:
        os.close(held)


def _is_a_demos(directory: Path) -> bool:
    try:
        return _MARK in (directory / "config.toml").read_text(errors="replace")
    except OSError:
        return False
