"""import-linter's contracts (pyproject.toml): directions, layers, interfaces, no circles, light daemons."""

from pathlib import Path

import grimp
import pytest
from importlinter import cli

from tests.fixtures.imports import ROOT
from tests.plugins.interface_contract import InterfaceContract, crossings, interface_of

FOLDERS = (
    "common",
    "configs",
    "controller",
    "supervisor",
    "drivers",
    "simulation",
    "diagnosis",
    "benchmarks",
)


def test_every_contract_is_kept(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """`.venv/bin/lint-imports` prints the same."""
    monkeypatch.chdir(ROOT)
    status = cli.lint_imports(no_cache=True)
    assert status == 0, capsys.readouterr().out


@pytest.mark.parametrize("folder", FOLDERS)
def test_a_folder_is_installed_by_one_name(folder: str) -> None:
    """stillarm/FOLDER is a link to the folder at the top: the file that is edited is the one that is imported."""
    link = ROOT / "stillarm" / folder
    assert link.is_symlink() and link.readlink() == Path("..") / folder


def test_an_import_past_an_interface_is_found() -> None:
    """The loop's own parts may import each other; the rig may not import one that the loop does not offer."""
    public = interface_of("stillarm.controller.loop") or frozenset()
    private = next(
        p.stem for p in sorted((ROOT / "controller" / "loop").glob("[a-z]*.py")) if p.stem not in public
    )
    graph = grimp.ImportGraph()
    graph.add_import(
        importer="stillarm.controller.loop.daemon", imported=f"stillarm.controller.loop.{private}"
    )
    graph.add_import(importer="stillarm.simulation.rig.rig", imported=f"stillarm.controller.loop.{private}")
    check = InterfaceContract("interface", {}, {}).check(graph, verbose=False)
    (wrong,) = [
        line for line in check.metadata["wrong"] if f" imports stillarm.controller.loop.{private}" in line
    ]
    assert not check.kept and wrong.startswith("stillarm.simulation.rig.rig imports")


def test_an_import_crosses_every_border_that_it_passes() -> None:
    assert crossings("a.b.x", "a.c.d.y") == [("a.c", "d"), ("a.c.d", "y")]
    assert crossings("a.c.x", "a.c.d.y") == [("a.c.d", "y")]
    assert crossings("a.c.x", "a.c.y") == []
