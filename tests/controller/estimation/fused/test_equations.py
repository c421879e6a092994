"""docs/fused.md and the modules of fused/ tell of the same equations, and the page's links lead somewhere."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from tests.fixtures.imports import ROOT

PAGE = ROOT / "docs" / "fused.md"
FUSED = ROOT / "controller" / "estimation" / "fused"
MODULES = [
    path
    for path in sorted(FUSED.rglob("*.py"))
    if path.name != "__init__.py" and path.parent.name != "assumptions"
]
"""The numbers in assumptions/ belong to the modules that use them."""


@cache
def equations() -> list[int]:
    """Numbers at the right margin of the page's indented lines, in order."""
    return [int(number) for number in re.findall(r"^ {4,}\S.*\((\d+)\)$", PAGE.read_text(), re.M)]


def cited(path: Path) -> set[int]:
    """Numbers after "Eq." or "Eqs." in a module, ranges included."""
    numbers: set[int] = set()
    for words in re.findall(r"Eqs?\. (\d+(?:(?:, | and | to )\d+)*)", path.read_text()):
        for part in re.split(r", | and ", words):
            first, _, last = part.partition(" to ")
            numbers |= set(range(int(first), int(last or first) + 1))
    return numbers


def test_equations_are_numbered_in_their_order() -> None:
    assert equations() == list(range(1, len(equations()) + 1))
    assert len(equations()) > 50


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(FUSED)))
def test_each_module_says_which_equations_it_implements(path: Path) -> None:
    own = re.findall(r"Eqs?\. \d+", ast.get_docstring(ast.parse(path.read_text())) or "")
    assert own, f"{path.name} cites no equation in its docstring"
    assert cited(path) <= set(equations()), f"{path.name}: {cited(path) - set(equations())} are not there"


def test_each_equation_is_implemented_somewhere() -> None:
    """By a module that names it in a short list; a range that spans chapters is no claim to implement them."""
    named = {
        number
        for path in MODULES
        for words in re.findall(r"Implements Eqs?\. (\d+(?:, \d+)*) of", path.read_text())
        for number in map(int, words.split(", "))
    }
    assert set(equations()) == named


def test_a_number_in_the_text_is_one_of_an_equation() -> None:
    text = PAGE.read_text()
    for number in re.findall(r"(?<![\w>])\((\d{1,3})(?:; [\w ]+)?\)", text):
        assert int(number) in equations(), f"({number})"


def test_every_link_leads_somewhere() -> None:
    links = re.findall(r"\]\(([^)#]+)[^)]*\)", PAGE.read_text())
    assert links
    for link in links:
        assert (PAGE.parent / link).exists(), link


def test_no_file_is_long() -> None:
    """A reader takes in a file of 300 lines; beyond that it does several things."""
    for path in FUSED.rglob("*.py"):
        assert len(path.read_text().splitlines()) <= 300, path.name
