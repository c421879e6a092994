"""What a recording holds of channels whose scale nobody knows: their own numbers, with the role that they have."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stillarm.common.recording.reader import Recording
from stillarm.tables.description import NOTE_NAME, ChannelEntry, TableEntry, parse_description, scale_of
from stillarm.tables.importing import kept_name
from stillarm.tables.roles import IGNORE, UNKNOWN


@dataclass(frozen=True)
class UnscaledChannel:
    """role(t) = a * values + b, with a and b to be fitted. time_s, values: shape (rows,); NaN: no measurement."""

    role: str
    name: str
    time_s: NDArray[np.float64]
    values: NDArray[np.float64]


def unscaled_channels(recording: Recording) -> list[UnscaledChannel]:
    """The channels of an import whose scale the description calls unknown. Raises UserError for a damaged recording."""
    text = recording.header.notes.get(NOTE_NAME)
    if text is None:
        return []
    description = parse_description(text, f"{recording.path}: import description")
    kept = [name for name in ("/fast/columns", "/frames/columns") if recording.counts.get(name)]
    tables = [recording.columns(name) for name in kept]
    return [
        found
        for entry in description.tables
        for channel in entry.channels
        if channel.role not in (UNKNOWN, IGNORE) and scale_of(channel) is None
        for table in tables
        if (found := _channel(table, entry, channel)) is not None
    ]


def _channel(
    table: dict[str, NDArray[Any]], entry: TableEntry, channel: ChannelEntry
) -> UnscaledChannel | None:
    names = {channel.column, kept_name(entry, channel, many=True)}
    rows = zip(table["time_s"].tolist(), table["columns"].tolist(), strict=True)
    held = [(t, row[name]) for t, row in rows for name in names if isinstance(row.get(name), float | int)]
    if not held:
        return None
    time_s, values = np.array(held, dtype=np.float64).T
    return UnscaledChannel(channel.role, channel.column, time_s, values)
