"""What has to agree before a release: the tag, the citation and the changelog with pyproject.toml's version."""

import re
import subprocess
import tomllib
from pathlib import Path


def version_of(root: Path) -> str:
    """The one place: project.version of pyproject.toml."""
    return str(tomllib.loads((root / "pyproject.toml").read_text())["project"]["version"])


def mistakes(root: Path, version: str, *, tagged: bool) -> list[str]:
    """One line for each that disagrees. tagged: also the commit's tag, and a section of the changelog."""
    wrong = []
    if (cited := re.findall(r"^version: (.+)$", (root / "CITATION.cff").read_text(), re.M)) != [version]:
        wrong.append(f"CITATION.cff: version {', '.join(cited)}; pyproject.toml says {version}: write that")
    if not tagged:
        return wrong
    if f"## [{version}]" not in (root / "CHANGELOG.md").read_text():
        wrong.append(
            f"CHANGELOG.md: no section [{version}]; move what is under [Unreleased] there, with the date"
        )
    words = ("git", "tag", "--points-at", "HEAD")
    tags = subprocess.run(words, cwd=root, capture_output=True, text=True, check=True).stdout.split()
    if f"v{version}" not in tags:
        wrong.append(f"the commit has no tag v{version}: `git tag v{version}`, or build with --untagged")
    return wrong
