"""A recording's channels as NumPy arrays with units, and as a data frame where pandas or polars is installed."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from stillarm.common.datagrams.fields import unit_of
from stillarm.common.files.model import Model, check_model
from stillarm.common.files.typed_toml import parse_toml
from stillarm.common.recording.reader import Recording, open_recording
from stillarm.common.recording.topics import TOPICS
from stillarm.common.user_error import UserError

Library = Literal["pandas", "polars"]


@dataclass(frozen=True)
class Table(Mapping[str, NDArray[Any]]):
    """Columns of one length by name: `table["acceleration_m_s2"]`. A number that was not measured is NaN.

    Shape (rows,); a channel with one number for each mode has (rows, modes). Texts are arrays of objects.
    """

    name: str
    columns: Mapping[str, NDArray[Any]]

    def __getitem__(self, channel: str) -> NDArray[Any]:
        """Raises UserError, which names the channels that are there."""
        try:
            return self.columns[channel]
        except KeyError:
            raise UserError(
                f"{self.name}: no channel {channel!r}; there are {', '.join(self.columns)}"
            ) from None

    def __contains__(self, channel: object) -> bool:
        return channel in self.columns

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return max((len(column) for column in self.columns.values()), default=0)

    @property
    def units(self) -> dict[str, str]:
        """The unit of each channel; empty for counts and texts."""
        return {name: unit_of(name) for name in self.columns}

    def frame(self, library: Library | None = None) -> Any:
        """The table as a data frame of pandas or polars; None: of the one that is installed, pandas first.

        A channel with a number for each mode becomes one column for each. The frame's columns keep their names, which
        carry the units. Raises UserError where neither is installed.
        """
        for name in (library,) if library else ("pandas", "polars"):
            try:
                return import_module(name).DataFrame(self._flat())
            except ModuleNotFoundError:
                continue
        wanted = library or "pandas"
        raise UserError(
            f"frame: {library or 'neither pandas nor polars'} not installed; run `pip install {wanted}`"
        )

    def _flat(self) -> dict[str, NDArray[Any]]:
        flat: dict[str, NDArray[Any]] = {}
        for name, column in self.columns.items():
            if column.ndim == 1:
                flat[name] = column
            else:
                flat |= {f"{name}_{place + 1}": column[:, place] for place in range(column.shape[1])}
        return flat

    def __repr__(self) -> str:
        return f"<{self.name}: {self.rows} rows of {', '.join(self.columns)}>"


@dataclass(frozen=True)
class Channels(Mapping[str, Table]):
    """A recording in memory: its tables by name, such as `fast` and `frames` (docs/topics.md), and its model."""

    path: Path
    model: Model
    tables: Mapping[str, Table]

    def __getitem__(self, name: str) -> Table:
        """Raises UserError, which names the tables that are there."""
        try:
            return self.tables[name]
        except KeyError:
            raise UserError(f"{self.path}: no table {name!r}; there are {', '.join(self.tables)}") from None

    def __contains__(self, name: object) -> bool:
        return name in self.tables

    def __iter__(self) -> Iterator[str]:
        return iter(self.tables)

    def __len__(self) -> int:
        return len(self.tables)

    @property
    def fast(self) -> Table:
        """A row for each cycle: accelerometer, joint, command. Raises UserError where there are none."""
        return self["fast"]

    @property
    def frames(self) -> Table:
        """A row for each visual sample. Raises UserError where there are none."""
        return self["frames"]

    def __repr__(self) -> str:
        sizes = ", ".join(f"{name} {table.rows}" for name, table in self.tables.items())
        return f"<{self.path}: rows of {sizes}>"


def load(recording: str | Path) -> Channels:
    """Read a recording (MCAP): each topic as a table of arrays. Channels that were never measured are left out.

    A truth file of the simulated rig is read, too. Raises UserError for a file that is no recording.
    """
    opened = open_recording(recording)
    name = f"{opened.path} (model)"
    model = check_model(parse_toml(opened.header.model, Model, name), name)
    tables = {
        topic.short_name: Table(topic.short_name, _measured(opened, topic.name))
        for topic in TOPICS
        if opened.counts.get(topic.name)
        and topic.short_name != "images"
        and not topic.name.endswith("/columns")
    }
    return Channels(opened.path, model, tables)


def _measured(recording: Recording, topic: str) -> dict[str, NDArray[Any]]:
    columns = recording.columns(topic)
    return {name: column for name, column in columns.items() if not _absent(column)}


def _absent(column: NDArray[Any]) -> bool:
    return column.dtype.kind == "f" and bool(np.isnan(column).all())


__all__ = ["Channels", "Table", "load"]
