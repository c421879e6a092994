"""Every picture that a page shows is there, small, and drawn by a command."""

import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.fixtures.imports import ROOT
from tests.fixtures.pages import PAGES

IMAGES = ROOT / "docs" / "images"
DRAWN_ELSEWHERE = {
    *("overview.png", "diagnosis-confusion.png", "diagnosis-sizes.png", "diagnosis-reliability.png"),
    *("panel-live.png", "panel-recording.png", "panel-diagnosis.png"),
}
"""By `make demo`, `stillarm benchmark diagnosis` and stillarm.benchmarks.diagnosis.reliability; the panel's by
`python docs/screenshots`."""
_LARGEST = 2_000_000  # bytes


def drawn() -> set[str]:
    """Names in the table of docs/figures."""
    source = (ROOT / "docs" / "figures" / "__main__.py").read_text()
    return {f"{name}.svg" for name in re.findall(r'^    "([\w-]+)": \w+\.draw,', source, re.M)}


@pytest.mark.parametrize("page", PAGES, ids=str)
def test_each_picture_of_a_page_is_there_and_has_a_text(page: Path) -> None:
    for text, target in re.findall(r"!\[([^\]]*)\]\(([^)]+)\)", (ROOT / page).read_text()):
        path = (ROOT / page).parent / target
        assert text and path.is_file(), f"{page}: {target}"
        assert path.name in drawn() | DRAWN_ELSEWHERE, f"{page}: no command draws {path.name}"


def test_each_picture_is_whole_small_and_drawn_by_the_table() -> None:
    assert {path.name for path in IMAGES.iterdir()} == drawn()
    for path in IMAGES.iterdir():
        assert path.stat().st_size < _LARGEST
        assert ElementTree.parse(path).getroot().tag.endswith("svg")


def test_the_moving_picture_moves_without_a_script() -> None:
    text = (IMAGES / "stilled.svg").read_text()
    assert text.count("<animate") >= 4 and "<script" not in text


@pytest.mark.slow
def test_the_command_draws_the_same_again(tmp_path: Path) -> None:
    """The quickest of them; the others take a simulation."""
    figures = str(ROOT / "docs" / "figures")
    again = tmp_path / "wiring.svg"
    code = "import sys, pathlib; sys.path.insert(0, sys.argv[1]); import wiring; wiring.draw(pathlib.Path(sys.argv[2]))"
    subprocess.run([sys.executable, "-c", code, figures, str(again)], check=True)
    assert again.read_bytes() == (IMAGES / "wiring.svg").read_bytes()
