"""One daemon of a kind on its ports: a lock file that names the process, held as long as that lives.

The kernel releases the lock when the process ends for any reason: the file of a killed process is no obstacle, and no
process number is ever trusted.
"""

import atexit
import contextlib
import fcntl
import os
import tempfile
from pathlib import Path

from stillarm.common.user_error import UserError, reason_of


def lock_folder() -> Path:
    """RUNTIME_DIRECTORY as systemd gives it, else XDG_RUNTIME_DIR, else the folder for temporary files."""
    named = os.environ.get("RUNTIME_DIRECTORY", "").split(":")[0] or os.environ.get("XDG_RUNTIME_DIR", "")
    return Path(named) if named and Path(named).is_dir() else Path(tempfile.gettempdir())


def hold_instance(role: str, port: int) -> int:
    """Take the lock of `role` at `port` until this process ends; returns its descriptor.

    Raises UserError when another process holds it, with its number.
    """
    path = lock_folder() / f"stillarm-{role}-{port}.lock"
    while not _is_at(descriptor := _locked(path, role, port), path):
        os.close(descriptor)  # its holder ended, and removed it, between our opening and locking it
    os.ftruncate(descriptor, 0)
    os.pwrite(descriptor, f"{os.getpid()}\n".encode(), 0)
    atexit.register(_remove, descriptor, path, os.getpid())
    return descriptor


def _locked(path: Path, role: str, port: int) -> int:
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o600)
    except OSError as error:
        raise UserError(
            f"{path}: cannot be opened ({reason_of(error)}); remove it, or set XDG_RUNTIME_DIR"
        ) from None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        holder = os.pread(descriptor, 20, 0).decode(errors="replace").strip() or "unknown"
        os.close(descriptor)
        raise UserError(
            f"a {role} runs already on port {port} (process {holder}); stop it first, or choose another port"
        ) from None
    return descriptor


def _is_at(descriptor: int, path: Path) -> bool:
    """Whether an open file is still the one of that name."""
    with contextlib.suppress(OSError):
        there, held = path.stat(), os.fstat(descriptor)
        return (there.st_dev, there.st_ino) == (held.st_dev, held.st_ino)
    return False


def _remove(descriptor: int, path: Path, process: int) -> None:
    """Remove the file at the process's end, while it still holds the lock."""
    if os.getpid() == process and _is_at(descriptor, path):
        path.unlink(missing_ok=True)
