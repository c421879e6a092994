"""Opens a file of any format that is known: by its first bytes, then by its suffix.

Libraries that read foreign formats raise exceptions of any kind on a damaged file. Here that becomes one line.
"""

import importlib
from collections.abc import Callable
from pathlib import Path

from stillarm.common.user_error import UserError, reason_of
from stillarm.tables.table import TableFile

_MAGIC = (
    (b"\x89MCAP0\r\n", "mcap"),
    (b"PAR1", "parquet"),
    (b"\x93NUMPY", "numpy"),
    (b"PK\x03\x04", "numpy"),
    (b"\x89HDF\r\n\x1a\n", "hdf5"),
    (b"MATLAB 5.0 MAT-file", "mat"),
)
_SUFFIX = {
    ".mcap": "mcap",
    ".parquet": "parquet",
    ".pq": "parquet",
    ".npy": "numpy",
    ".npz": "numpy",
    ".mat": "mat",
    ".h5": "hdf5",
    ".hdf5": "hdf5",
}
_NOT_TABLES = {
    ".xlsx": "an Excel workbook; save the sheet as CSV",
    ".xls": "an Excel workbook; save the sheet as CSV",
    ".ods": "a spreadsheet; save the sheet as CSV",
    ".db3": "a ROS 2 bag in SQLite; convert it with `ros2 bag convert` to storage mcap",
    ".bag": "a ROS 1 bag; convert it with `rosbags-convert` to a ROS 2 bag with storage mcap",
    ".mp4": "a video; `stillarm track` turns it into the visual channel",
    ".avi": "a video; `stillarm track` turns it into the visual channel",
}
_HDF5_IN_MAT = 512  # a MAT file of version 7.3 is HDF5 behind a block of text


def read_table_file(path: str | Path) -> TableFile:
    """The tables of a file, or of a ROS 2 bag (a folder). Raises UserError, one line."""
    path = Path(path)
    kind = _kind(path)
    try:
        return _reader(kind)(path)
    except (UserError, KeyboardInterrupt):
        raise
    except MemoryError:
        raise UserError(f"{path}: more than this machine's memory; cut the file into parts") from None
    except Exception as error:  # a damaged file may raise anything in a foreign reader
        text = reason_of(error) if isinstance(error, OSError) else str(error)
        said = " ".join(text.split())[:120] or type(error).__name__
        raise UserError(
            f"{path}: cannot be read as {_NAMES[kind]} ({said}); the file is damaged, or cut"
        ) from None


_NAMES = {
    "csv": "CSV",
    "mat": "a MAT file",
    "hdf5": "HDF5 (MAT v7.3)",
    "parquet": "Parquet",
    "numpy": "NumPy",
    "mcap": "MCAP",
}


def _kind(path: Path) -> str:
    if path.is_dir():
        return "mcap"
    try:
        with path.open("rb") as file:
            head = file.read(_HDF5_IN_MAT + 8)
    except OSError as error:
        raise UserError(f"{path}: cannot be read ({reason_of(error)}); name an existing file") from None
    if not head:
        raise UserError(f"{path}: empty; a file with rows of numbers is needed")
    suffix = path.suffix.lower()
    if suffix in _NOT_TABLES:
        raise UserError(f"{path}: {_NOT_TABLES[suffix]}")
    if head[_HDF5_IN_MAT : _HDF5_IN_MAT + 8] == b"\x89HDF\r\n\x1a\n":
        return "hdf5"
    return next((kind for magic, kind in _MAGIC if head.startswith(magic)), _SUFFIX.get(suffix, "csv"))


def _reader(kind: str) -> Callable[[Path], TableFile]:
    module = importlib.import_module(f"stillarm.tables.readers.{kind}_file")
    reader: Callable[[Path], TableFile] = module.read
    return reader


def needed(package: str, what: str, extra: str) -> UserError:
    """The one line for a package that is not installed."""
    return UserError(
        f"{what}: needs the package {package}; `pip install 'stillarm[{extra}]'` or `pip install {package}`"
    )
