"""What a recording holds of channels whose scale nobody knows: their own numbers, with the role that they have."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stillarm.common.recording.reader import Recording
from stillarm.tables.description import NOTE_NAME, parse_description, scale_of
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
    if text is None or not recording.counts.get("/fast/columns"):
        return []
    description = parse_description(text, f"{recording.path}: import description")
    table = recording.columns("/fast/columns")
    many = len(description.tables) > 1
    found = []
    for entry in description.tables:
        for channel in entry.channels:
            if channel.role in (UNKNOWN, IGNORE) or scale_of(channel) is not None:
                continue
            names = {channel.column, kept_name(entry, channel, many or bool(entry.name))}
            rows = [
                (t, next((row[n] for n in names if n in row), None))
                for t, row in zip(table["time_s"], table["columns"], strict=True)
            ]
            held = [(t, value) for t, value in rows if isinstance(value, float | int)]
            if held:
                time_s, values = np.array(held, dtype=np.float64).T
                found.append(UnscaledChannel(channel.role, channel.column, time_s, values))
    return found
