"""Imports run one way: stillarm -> diagnosis -> simulation -> controller, supervisor -> drivers -> common."""

import ast
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
ALLOWED = {
    "common": {"common"},
    "drivers": {"drivers", "common"},
    "controller": {"controller", "drivers", "common"},
    "supervisor": {"supervisor", "drivers", "common"},
    "simulation": {"simulation", "controller", "supervisor", "drivers", "common"},
    "diagnosis": {"diagnosis", "simulation", "controller", "supervisor", "drivers", "common"},
}
EVERYWHERE = set(ALLOWED) | {"stillarm", "benchmarks", "tests"}
HEAVY = {"scipy", "matplotlib", "numba"}


@cache
def imported(path: Path) -> frozenset[str]:
    """Top-level packages that a file imports, anywhere in it."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            names.add(node.module.split(".")[0])
    return frozenset(names)


@pytest.mark.parametrize("package", sorted(ALLOWED))
def test_imports_run_one_way(package: str) -> None:
    """No file imports a package above its own."""
    for path in (ROOT / package).rglob("*.py"):
        wrong = (imported(path) & EVERYWHERE) - ALLOWED[package]
        assert not wrong, f"{path.relative_to(ROOT)} imports {sorted(wrong)}"


@pytest.mark.parametrize("package", ["common", "drivers", "controller", "supervisor"])
def test_heavy_packages_stay_out_of_the_daemons(package: str) -> None:
    """They take seconds to import and memory to hold."""
    for path in (ROOT / package).rglob("*.py"):
        assert not imported(path) & HEAVY, path.relative_to(ROOT)
