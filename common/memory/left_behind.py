"""Finds and removes shared memory that a killed process has left: blocks that no process has mapped."""

import contextlib
import os
from pathlib import Path

from stillarm.common.memory.shared_memory import block_path


def mapped_blocks() -> set[int]:
    """The inodes of all blocks that some process of this computer has mapped, as far as it may be looked at.

    Raises PermissionError where one that may have a block cannot be looked at: then nobody can say that it is left.
    """
    folder = str(block_path("x").parent)
    inodes = set()
    for process in Path("/proc").iterdir():
        if not process.name.isdigit():
            continue
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):
            for line in _maps(process).splitlines():
                fields = line.split(maxsplit=5)
                if len(fields) == 6 and fields[5].startswith(f"{folder}/stillarm-"):
                    inodes.add(int(fields[4]))
    return inodes


def _maps(process: Path) -> str:
    try:
        return (process / "maps").read_text(errors="replace")
    except PermissionError:
        if b"python" in (process / "cmdline").read_bytes():  # stillarm's run in it
            raise
        return ""


def remove_left_blocks(*, older_than_s: float = 60.0) -> list[str]:
    """Remove this user's blocks that no process has mapped any more; returns their names.

    older_than_s: one that was made later may be about to be opened.
    """
    removed: list[str] = []
    candidates = list(block_path("x").parent.glob("stillarm-*"))
    if not candidates:
        return removed
    try:
        mapped = mapped_blocks()
    except OSError:  # no /proc, or processes of other users
        return removed
    now = _newest_time_s()
    for path in candidates:
        with contextlib.suppress(OSError):
            status = path.stat()
            if (
                status.st_uid == os.getuid()
                and status.st_ino not in mapped
                and now - status.st_ctime > older_than_s
                and path.is_file()
                and path.suffix != ".lock"
            ):
                path.unlink()
                removed.append(path.name)
    return removed


def _newest_time_s() -> float:
    """The file system's own present time: of a file made now."""
    probe = block_path(f"probe-{os.getpid()}")
    try:
        probe.touch()
        return probe.stat().st_ctime
    except OSError:
        return 0.0
    finally:
        probe.unlink(missing_ok=True)
