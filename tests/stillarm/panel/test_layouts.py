"""The layouts for Foxglove and PlotJuggler name only curves that the telemetry has."""

import json
import re
from pathlib import Path
from xml.etree import ElementTree

from stillarm.panel.live.foxglove_bridge import SENT, schema_of

CONFIGS = Path(__file__).parents[3] / "configs"


def has(topic: str, field: str) -> bool:
    return topic in SENT and field in schema_of(topic)["properties"]


def test_foxgloves_layout_names_channels_and_fields_that_are_sent() -> None:
    layout = json.loads((CONFIGS / "foxglove_layout.json").read_text())
    paths = [
        path["value"]
        for name, panel in layout["configById"].items()
        for path in panel.get("paths", [])
        if name.startswith("Plot!")
    ]
    assert len(paths) >= 5 and all(has(*path.removeprefix("/").split(".")) for path in paths)
    shown = set(re.findall(r'"((?:Plot|RawMessages)!\w+)"', json.dumps(layout["layout"])))
    assert shown == set(layout["configById"])


def test_plotjugglers_layout_names_fields_that_are_sent() -> None:
    root = ElementTree.parse(CONFIGS / "plotjuggler_layout.xml").getroot()
    curves = [curve.attrib["name"] for curve in root.iter("curve")]
    assert len(curves) >= 5 and all(has(*curve.split("/")) for curve in curves)
