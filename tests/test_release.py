"""What has to agree before a release, and what a stranger finds at the top of the repository."""

import importlib.util
import shutil
import subprocess
import tomllib
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from tests.fixtures.imports import ROOT


def loaded(name: str) -> ModuleType:
    """deploy/release/NAME.py, which is in no package."""
    place = ROOT / "deploy" / "release" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(f"release_{name}", place)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


checks, audit = loaded("checks"), loaded("audit")


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """The three files, in a repository of one commit."""
    for name in ("pyproject.toml", "CITATION.cff", "CHANGELOG.md"):
        shutil.copy(ROOT / name, tmp_path)
    for words in (["init", "-q"], ["add", "."], ["commit", "-q", "-m", "all"]):
        who = ["-c", "user.name=x", "-c", "user.email=x@example.org"]
        subprocess.run(["git", *who, *words], cwd=tmp_path, check=True, capture_output=True)
    return tmp_path


def test_the_citation_and_the_metadata_agree_here() -> None:
    assert checks.mistakes(ROOT, checks.version_of(ROOT), tagged=False) == []
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    for name in project["license-files"]:
        assert "Apache License" in (ROOT / name).read_text()[:200]


@pytest.mark.slow
def test_a_release_needs_its_tag_its_section_and_its_citation(tree: Path) -> None:
    version = checks.version_of(tree)
    (tree / "CITATION.cff").write_text("version: 0.0.9\n")
    said = " / ".join(checks.mistakes(tree, version, tagged=True))
    assert "0.0.9" in said and f"[{version}]" in said and f"git tag v{version}" in said
    (tree / "CITATION.cff").write_text(f"version: {version}\n")
    (tree / "CHANGELOG.md").write_text(f"## [{version}] - 2026-12-01\n")
    subprocess.run(["git", "tag", f"v{version}"], cwd=tree, check=True)
    assert checks.mistakes(tree, version, tagged=True) == []


def answer(name: str, *vulnerabilities: str) -> dict[str, Any]:
    """pip-audit's JSON for a package that was looked up."""
    vulns = [{"id": one, "fix_versions": ["2.0"], "description": ""} for one in vulnerabilities]
    return {"name": name, "version": "1.0", "vulns": vulns}


def test_a_package_that_one_database_knows_is_audited() -> None:
    skipped = {"name": "mcap", "skip_reason": "Dependency not found on PyPI"}
    answers = {"pypi": [answer("numpy"), skipped], "osv": [answer("mcap")]}
    clean, lines = audit.verdict(["mcap", "numpy"], answers)
    assert clean and lines == ["audited: 2 packages, no known vulnerability"]


def test_what_no_database_could_be_asked_about_is_no_pass() -> None:
    clean, (line,) = audit.verdict(["mcap", "numpy"], {"pypi": [answer("numpy")], "osv": []})
    assert not clean and "NOT AUDITED" in line and "1 of 2 packages (mcap)" in line


def test_a_vulnerability_is_named_with_its_remedy() -> None:
    clean, lines = audit.verdict(["numpy"], {"pypi": [answer("numpy", "PYSEC-1")], "osv": []})
    assert not clean and lines == ["numpy 1.0: PYSEC-1 (pypi); mended in 2.0"]


def test_our_own_package_is_not_looked_up(tmp_path: Path) -> None:
    for name in ("stillarm-0.1.0", "Typing_Extensions-4.0"):
        (tmp_path / f"{name}.dist-info").mkdir()
    assert audit.installed(tmp_path) == ["typing-extensions"]
