"""Schemas in the plain form that other programs read."""

import json

from stillarm.common.recording.json_schema import json_schema
from stillarm.common.recording.topics import TOPICS


def test_each_schema_names_every_field_with_one_plain_type() -> None:
    for topic in TOPICS:
        schema = json.loads(json_schema(topic.message))
        assert list(schema["properties"]) == list(topic.message.__struct_fields__)
        for kind in schema["properties"].values():  # Foxglove takes no list of types
            assert kind["type"] in {"number", "integer", "boolean", "string", "array", "object"}
