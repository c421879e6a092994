"""A file that only grows by whole records: a failed write is undone.

The package mcap leaves half a record there when the disk is full.
"""

import contextlib
from pathlib import Path
from typing import IO, cast

from mcap.writer import MCAP0_MAGIC

from stillarm.common.user_error import UserError, reason_of


def _spare_other_files(path: Path) -> None:
    """A slip in an argument must not cost a model file or a table."""
    with contextlib.suppress(OSError):  # not there, or not to be read: opening it tells
        if not path.is_file():
            return
        with path.open("rb") as file:
            start = file.read(len(MCAP0_MAGIC))
        if not MCAP0_MAGIC.startswith(start):
            raise UserError(
                f"{path}: exists and is no recording, so it is not replaced; name another file, or remove it"
            )


class AppendFile:
    """The file that the MCAP writer writes to. Each write() adds one or more whole records, or fails and is undone."""

    def __init__(self, path_or_file: str | Path | IO[bytes]) -> None:
        """Make the file, or write to one that is open. An earlier recording of that name is replaced, any other
        file is not. Raises UserError.
        """
        self._own = isinstance(path_or_file, str | Path)
        if isinstance(path_or_file, str | Path):
            self.name = str(path_or_file)
            _spare_other_files(Path(path_or_file))
            try:
                self._file = cast(IO[bytes], Path(path_or_file).open("wb", buffering=0))  # noqa: SIM115 - closed by close()
            except OSError as error:
                raise UserError(
                    f"{self.name}: cannot be written ({reason_of(error)}); "
                    "name a file in an existing folder that you may write to"
                ) from None
        else:
            self._file = path_or_file
            self.name = str(getattr(path_or_file, "name", "recording"))
        self._length = 0

    def write(self, data: bytes) -> int:
        """Append all of `data`; after an OSError, which is passed on, the file has its former length."""
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[self._file.write(rest) :]
        except OSError:
            with contextlib.suppress(OSError):
                self._file.seek(self._length)
                self._file.truncate()
            raise
        self._length += len(data)
        return len(data)

    def tell(self) -> int:
        """Length so far."""
        return self._length

    def flush(self) -> None:
        """Hand everything to the operating system."""
        self._file.flush()

    def close(self) -> None:
        """Close the file if it was opened here; may be called twice."""
        if self._own:
            self._file.close()
