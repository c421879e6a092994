"""What has to agree before a release, and what a stranger finds at the top of the repository."""

import importlib.util
import shutil
import subprocess
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

from tests.fixtures.imports import ROOT


def loaded() -> ModuleType:
    """deploy/release/checks.py, which is in no package."""
    spec = importlib.util.spec_from_file_location("release_checks", ROOT / "deploy" / "release" / "checks.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


checks = loaded()


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
