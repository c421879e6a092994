"""`stillarm causes`: what it prints, and the page that comes from it."""

import json
from pathlib import Path

import pytest

from stillarm.causes_page import ALL_CAUSES, page, schema, section

ROOT = Path(__file__).parents[2]


def test_the_documentation_is_what_the_declarations_say() -> None:
    """After a change: stillarm causes --markdown > docs/causes.md"""
    assert (ROOT / "docs" / "causes.md").read_text() == page()


@pytest.mark.parametrize("identifier", ALL_CAUSES)
def test_a_section_tells_every_parameter_with_its_range(identifier: str) -> None:
    cause, text = ALL_CAUSES[identifier], section(ALL_CAUSES[identifier])
    for one in cause.parameters:
        line = next(line for line in text.splitlines() if line.startswith(f"- `{one.name}`: "))
        if one.kind in ("number", "whole"):
            assert f"{one.unit}, {one.lowest:g} to {one.highest:g}" in line
        assert ("when left out" in line) == (one.default is not None)
    assert f"    {cause.equation}\n" in text
    assert "\nTo provoke it: " in text and "\nTo tell it from " in text


def test_the_schema_bounds_what_the_checks_bound() -> None:
    entries = {entry["properties"]["cause"]["const"]: entry for entry in schema()["oneOf"]}
    assert list(entries) == list(ALL_CAUSES)
    cubic = entries["cubic_stiffness"]
    assert cubic["required"] == ["cause", "coefficient_per_m2"]
    assert cubic["properties"]["coefficient_per_m2"]["maximum"] == 1e7
    assert entries["clock_step"]["properties"]["clock"] == {
        "enum": ["frames", "camera", "all"],
        "default": "frames",
    }
    assert "default" not in entries["channel_delay"]["properties"]["channel"]
    json.loads(json.dumps(schema(), allow_nan=False))
    assert entries["stale_frame_buffer"]["properties"]["frames"]["type"] == "integer"
