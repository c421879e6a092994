"""The tutorials and notebooks, from their first line to their last, as a new user would: `make tutorials`."""

import os
import re
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

from tests.fixtures.imports import ROOT
from tests.fixtures.pages import Block, blocks

TUTORIALS = ("demo", "first-recording", "box-of-parts")
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
_BIN = Path(sys.executable).parent

pytestmark = [pytest.mark.tutorial]


def script_of(page: list[Block]) -> str:
    """The page as one shell script, since a command may go on behind the next ones. Output is separated by marks."""
    parts = ["set -m", "trap 'kill $(jobs -p) 2>/dev/null' EXIT"]
    for block in page:
        if block.kind == "toml" and block.file:
            parts.append(f"cat > {block.file} <<'END_OF_FILE'\n{block.text}END_OF_FILE")
        elif block.kind == "python":
            parts.append(f"python - <<'END_OF_FILE' || exit 1\n{block.text}END_OF_FILE")
        elif block.kind == "console":
            for command, _ in block.commands:
                behind = command.endswith("&")
                parts.append(
                    f"echo '@@@'; {command}" if behind else f"echo '@@@'; {{ {command}; }} || exit 1"
                )
    return "\n".join(parts) + "\necho '@@@'\n"


def masked(line: str) -> str:
    """A line without its figures, which differ from run to run, and without the width of its columns."""
    return re.sub(r"\d+(\.\d+)?", "#", " ".join(line.split()))


@pytest.mark.parametrize("name", TUTORIALS)
def test_a_tutorial_runs_to_its_end_and_prints_what_it_shows(name: str, tmp_path: Path) -> None:
    page = blocks(Path("docs") / "tutorials" / f"{name}.md")
    environment = os.environ | {"PATH": f"{_BIN}:{os.environ['PATH']}"}
    words = ["bash", "-c", script_of(page)]
    done = subprocess.run(
        words, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False, timeout=600
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    printed = done.stdout.split("@@@\n")[1:]
    commands = [pair for block in page if block.kind == "console" for pair in block.commands]
    assert len(printed) >= len(commands)
    for (command, shown), output in zip(commands, printed, strict=False):
        lines = [masked(line) for line in output.splitlines()]
        for line in shown:
            assert line == "..." or not line or masked(line) in lines, (
                f"{command}: no line {line!r} in\n{output}"
            )


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_to_its_end(path: Path, tmp_path: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)
    os.environ["STILLARM_REPOSITORY"] = str(ROOT)
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()


def test_there_are_three_notebooks_with_their_figures() -> None:
    assert len(NOTEBOOKS) == 3
    for path in NOTEBOOKS:
        outputs = [out for cell in nbformat.read(path, as_version=4).cells for out in cell.get("outputs", ())]
        assert any("image/png" in out.get("data", {}) for out in outputs), (
            f"{path.name}: commit it with its figures"
        )
