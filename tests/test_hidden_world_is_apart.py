"""The hidden world judges the diagnosis: it shares no code with what it judges."""

from tests.fixtures.imports import ROOT, imported

JUDGED = {
    "stillarm",
    "simulation",
    "diagnosis",
    "controller",
    "supervisor",
    "drivers",
    "common",
    "benchmarks",
}


def test_the_hidden_world_imports_nothing_of_the_program() -> None:
    files = list((ROOT / "tests" / "hidden_world").rglob("*.py"))
    assert len(files) > 10
    for path in files:
        assert not imported(path) & JUDGED, f"{path.name} imports {sorted(imported(path) & JUDGED)}"
        assert "importlib" not in imported(path), path.name


def test_nothing_of_the_program_knows_the_hidden_world() -> None:
    for package in ("simulation", "diagnosis", "controller", "supervisor", "drivers", "common"):
        for path in (ROOT / package).rglob("*.py"):
            assert "hidden_world" not in path.read_text(), path
