"""The JSON schema of a message type, in the plain form that Foxglove and PlotJuggler read."""

import msgspec

from stillarm.common.datagrams.fields import plain_types

# msgspec's own schema of a whole Struct refers to parts, which Foxglove does not follow
_KEPT = ("type", "items")


def json_schema(message: type[msgspec.Struct]) -> bytes:
    """JSON schema (root type object) of a message type, encoded; the same bytes each time.

    A float may be null in a message. A list of types would say so, but Foxglove takes only a single one.
    """
    types = {name: msgspec.json.schema(plain) for name, plain in plain_types(message).items()}
    return msgspec.json.encode(
        {
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            "title": message.__name__,
            "description": " ".join((message.__doc__ or "").split("\n\n", maxsplit=1)[0].split()),
            "type": "object",
            "properties": {
                name: {key: schema[key] for key in _KEPT if key in schema} for name, schema in types.items()
            },
            "required": list(types),
        }
    )
