"""Every command that a page shows is one that the program takes; every file that it shows is read without an error."""

import ast
import tomllib
from pathlib import Path

import msgspec
import pytest

from stillarm.common.files.configuration import Configuration
from stillarm.common.files.model import Model
from stillarm.common.files.scenario import Scenario
from stillarm.main import COMMANDS, command_parser
from tests.fixtures.pages import PAGES, blocks, stillarm_commands

OF_PAGES = [(page, words) for page in PAGES for words in stillarm_commands(page)]


def test_the_pages_show_commands_at_all() -> None:
    """Otherwise what follows holds of nothing."""
    assert len(OF_PAGES) > 60
    mentioned = {words[0] for page in PAGES for words in stillarm_commands(page, mentioned=True)}
    assert set(COMMANDS) <= {words[0] for _, words in OF_PAGES} | mentioned


def refusal(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """What the command line says against a command; empty where it takes it."""
    if words[0] not in COMMANDS:
        return "no such command"
    try:
        command_parser(words[0]).parse_args(words[1:])
    except SystemExit as end:
        return capsys.readouterr().err if end.code else ""
    return ""


@pytest.mark.parametrize("page", PAGES, ids=str)
def test_each_command_is_taken(page: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for words in stillarm_commands(page):
        assert not refusal(words, capsys), f"{page}: stillarm {' '.join(words)}"


@pytest.mark.parametrize("page", PAGES, ids=str)
def test_each_command_in_a_sentence_lacks_arguments_at_most(
    page: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for words in stillarm_commands(page, mentioned=True):
        said = refusal(words, capsys)
        assert not said or "arguments are required" in said, f"{page}: stillarm {' '.join(words)}: {said}"


@pytest.mark.parametrize(
    "page", [page for page in PAGES if any(b.kind == "toml" for b in blocks(page))], ids=str
)
def test_each_file_is_one_of_the_three_kinds(page: Path) -> None:
    for block in blocks(page):
        if block.kind == "toml":
            table = tomllib.loads(block.text)
            assert any(_reads(table, kind) for kind in (Configuration, Model, Scenario)), (
                f"{page}: {block.text}"
            )


def _reads(table: dict[str, object], kind: type[msgspec.Struct]) -> bool:
    try:
        msgspec.convert(table, kind)
    except msgspec.ValidationError:
        return False
    return True


@pytest.mark.parametrize("page", PAGES, ids=str)
def test_python_blocks_are_python(page: Path) -> None:
    """The tutorials' are run, too (test_tutorials.py)."""
    for block in blocks(page):
        if block.kind == "python" and not block.text.startswith(
            "# controller/estimation/methods.py: METHODS"
        ):
            ast.parse(block.text)
