"""docs/architecture.md walks an image, a cycle and a recording through the code: the stations are there, and few."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from tests.fixtures.imports import ROOT

PAGE = ROOT / "docs" / "architecture.md"
WALKS = (
    "One image, from its datagram to the command",
    "One cycle of the loop",
    "One recording, to its verdict",
)
MOST_STATIONS = 12


def stations(walk: str) -> list[str]:
    """The rows of a walk's table."""
    section = PAGE.read_text(encoding="utf-8").split(f"## {walk}\n", 1)[1].split("\n## ", 1)[0]
    return re.findall(r"^\| \d+ \|.*\|$", section, re.M)


@cache
def defined(path: Path) -> frozenset[str]:
    """Functions and classes of a module, and methods as Class.method."""
    names = set()
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        if isinstance(node, ast.ClassDef):
            names |= {f"{node.name}.{one.name}" for one in node.body if isinstance(one, ast.FunctionDef)}
    return frozenset(names)


@pytest.mark.parametrize("walk", WALKS)
def test_each_station_is_a_function_that_is_there(walk: str) -> None:
    rows = stations(walk)
    assert rows
    for row in rows:
        places = re.findall(r"\[([\w.]+)\]\(\.\./([\w/.]+)\) `([\w.]+)`", row)
        assert places, row
        for name, file, function in places:
            assert Path(file).name == name, row
            assert function in defined(ROOT / file), f"{file} has no {function}"


@pytest.mark.parametrize("walk", WALKS)
def test_a_walk_has_at_most_twelve_stations_in_order(walk: str) -> None:
    numbers = [int(row.split("|")[1]) for row in stations(walk)]
    assert numbers == list(range(1, len(numbers) + 1))
    assert len(numbers) <= MOST_STATIONS


@pytest.mark.parametrize("page", [PAGE, ROOT / "CONTRIBUTING.md"], ids=lambda page: page.name)
def test_every_link_leads_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text(encoding="utf-8"))
    for link in links:
        assert "://" in link or (page.parent / link).exists(), link
