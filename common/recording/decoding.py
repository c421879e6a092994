"""From the JSON of a recording's messages to their Structs and columns; null becomes NaN, floats come back exactly.

msgspec decodes, a whole chunk at a time. JSON has no NaN, so that null stands for NaN here.
"""

from collections.abc import Callable
from math import nan
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from stillarm.common.datagrams.fields import plain_types


class MessageMismatch(Exception):
    """A message does not fit its type: its index in the list that was given, and why."""

    def __init__(self, index: int, reason: str) -> None:
        """Name the message."""
        super().__init__(reason)
        self.index = index


def _loose(kind: Any) -> Any:
    return {float: float | None, list[float]: list[float | None]}.get(kind, kind)


class MessageDecoder:
    """Decodes the messages of one type. Unknown fields are passed over; absent ones take their defaults."""

    def __init__(self, message: type[msgspec.Struct]) -> None:
        """Make the decoder of a message type of the table of topics."""
        self._message = message
        self._kinds = plain_types(message)
        loose = msgspec.defstruct(
            message.__name__,
            [(f.name, _loose(self._kinds[f.name]), f.default) for f in msgspec.structs.fields(message)],
        )
        self._one = msgspec.json.Decoder(loose)
        self._many = msgspec.json.Decoder(list[loose])  # type: ignore[valid-type]

    def rows(self, encoded: list[bytes]) -> list[Any]:
        """The messages with None for null. Raises MessageMismatch."""
        try:
            rows: list[Any] = self._many.decode(b"[" + b",".join(encoded) + b"]")
        except _BAD_JSON:
            return [self._row(index, data) for index, data in enumerate(encoded)]
        if len(rows) != len(encoded):  # commas inside a damaged message
            return [self._row(index, data) for index, data in enumerate(encoded)]
        return rows

    def _row(self, index: int, data: bytes) -> Any:
        try:
            return self._one.decode(data)
        except _BAD_JSON as error:
            raise MessageMismatch(index, " ".join(str(error).split())) from None

    def structs(self, encoded: list[bytes]) -> list[msgspec.Struct]:
        """The messages. Raises MessageMismatch."""
        message, names = self._message, list(self._kinds)
        lists = [name for name, kind in self._kinds.items() if kind == list[float]]
        found = []
        for row in self.rows(encoded):
            for name in lists:
                setattr(row, name, [nan if value is None else value for value in getattr(row, name)])
            found.append(
                message(*[nan if (value := getattr(row, name)) is None else value for name in names])
            )
        return found

    def columns(self, blocks: list[list[Any]]) -> dict[str, NDArray[Any]]:
        """A column for each field from blocks of rows(): float64 (lists: a row each, NaN where shorter),
        int64, bool,
        object for texts."""
        return {
            name: _COLUMN.get(kind, _objects)([getattr(row, name) for block in blocks for row in block])
            for name, kind in self._kinds.items()
        }


def _objects(values: list[Any]) -> NDArray[Any]:
    column = np.empty(len(values), dtype=object)
    column[:] = values
    return column


def _table(values: list[list[float | None]]) -> NDArray[np.float64]:
    width = max(map(len, values), default=0)
    table = np.full((len(values), width), nan)
    for row, value in zip(table, values, strict=True):
        row[: len(value)] = value
    return table


_COLUMN: dict[Any, Callable[[list[Any]], NDArray[Any]]] = {
    float: lambda values: np.array(values, dtype=np.float64),
    int: lambda values: np.array(values, dtype=np.int64),
    bool: lambda values: np.array(values, dtype=np.bool_),
    list[float]: _table,
}
_BAD_JSON = (msgspec.DecodeError, UnicodeDecodeError, RecursionError)
