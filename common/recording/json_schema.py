"""The JSON schema of a message type, made from its Struct, in the plain form that Foxglove and PlotJuggler
read.
"""

from typing import Any

import msgspec

_PLAIN: dict[Any, dict[str, Any]] = {
    # A float may be null in a message. A list of types would say so, but Foxglove takes only a single one.
    float: {"type": "number"},
    int: {"type": "integer"},
    bool: {"type": "boolean"},
    str: {"type": "string"},
    list[float]: {"type": "array", "items": {"type": "number"}},
    dict[str, float | str | None]: {"type": "object"},
}


def json_schema(message: type[msgspec.Struct]) -> bytes:
    """JSON schema (root type object) of a message type, encoded; the same bytes each time."""
    fields = msgspec.structs.fields(message)
    return msgspec.json.encode(
        {
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            "title": message.__name__,
            "description": " ".join((message.__doc__ or "").split("\n\n", maxsplit=1)[0].split()),
            "type": "object",
            "properties": {field.encode_name: _PLAIN[field.type] for field in fields},
            "required": [field.encode_name for field in fields],
        }
    )
