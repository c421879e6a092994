"""The wheel: one name, each file once and as a file; beside PyPI's `supervisor` both run, and stay when one goes."""

import shutil
import subprocess
import sys
import tarfile
import zipfile
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FOLDERS = (
    "stillarm",
    "common",
    "configs",
    "controller",
    "supervisor",
    "drivers",
    "simulation",
    "diagnosis",
    "benchmarks",
)

SUFFIXES = (".py", ".pyi", ".typed", ".toml", ".css", ".html", ".js", ".json", ".svg", ".uplot", ".xml")

pytestmark = pytest.mark.slow


def run(*words: str | Path, cwd: Path, check: bool = True) -> subprocess.CompletedProcess[str]:
    """A process in a folder where the source tree cannot be found."""
    done = subprocess.run([str(word) for word in words], cwd=cwd, capture_output=True, text=True, check=False)
    assert not check or done.returncode == 0, f"{words[:4]}: {done.stdout[-2000:]}{done.stderr[-2000:]}"
    return done


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Wheel and source distribution, made out of a copy of the tree as git has it."""
    folder = tmp_path_factory.mktemp("built")
    tree = folder / "tree"
    tree.mkdir()
    for name in (*FOLDERS, "pyproject.toml", "README.md", "LICENSE"):
        source = ROOT / name
        if source.is_dir():
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(source, tree / name, symlinks=True, ignore=ignored)
        else:
            shutil.copy(source, tree / name)
    code = "from setuptools import build_meta as b; print(b.build_{}({!r}))"
    for kind in ("sdist", "wheel"):
        run(sys.executable, "-c", code.format(kind, str(folder)), cwd=tree)
    (wheel,), (source_distribution,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
    return wheel, source_distribution


def ours() -> set[str]:
    """Every module and data file, by its installed path."""
    files = set()
    for top in FOLDERS:
        for path in (ROOT / top).rglob("*"):
            inside = path.relative_to(ROOT)
            linked = top == "stillarm" and (ROOT / Path(*inside.parts[:2])).is_symlink()
            if path.is_file() and path.suffix in SUFFIXES and not linked:
                files.add(str(inside) if top == "stillarm" else f"stillarm/{inside}")
    return files


def test_the_wheel_holds_each_file_once_under_one_name(built: tuple[Path, Path]) -> None:
    with zipfile.ZipFile(built[0]) as wheel:
        names = [one.filename for one in wheel.infolist() if ".dist-info/" not in one.filename]
        links = [one.filename for one in wheel.infolist() if one.external_attr >> 16 & 0o170000 == 0o120000]
    assert Counter(names) == Counter(ours())
    assert links == []


def test_the_source_distribution_holds_each_file_once_and_as_a_file(built: tuple[Path, Path]) -> None:
    with tarfile.open(built[1]) as archive:
        members = {one.name.partition("/")[2]: one for one in archive.getmembers() if not one.isdir()}
    found = {name for name in members if name.startswith(tuple(f"{top}/" for top in FOLDERS))}
    assert found == ours()
    assert all(one.isfile() for one in members.values())


def test_beside_the_other_supervisor_both_run_and_stay(built: tuple[Path, Path], tmp_path: Path) -> None:
    """In an environment of its own; what stillarm depends on is seen through, not installed again."""
    environment = tmp_path / "environment"
    run(sys.executable, "-m", "venv", "--without-pip", environment, cwd=tmp_path)
    python = environment / "bin" / "python"
    pip = (sys.executable, "-m", "pip", "--python", python, "--disable-pip-version-check", "--quiet")
    got = run(*pip, "install", "--timeout", "10", "--retries", "0", "supervisor", cwd=tmp_path, check=False)
    if got.returncode:
        pytest.skip("the package `supervisor` cannot be had here: no index, and not in pip's cache")
    run(*pip, "install", "--no-deps", "--no-index", built[0], cwd=tmp_path)
    (packages,) = (environment / "lib").glob("python*/site-packages")
    dependencies = [path for path in sys.path if path.endswith("site-packages")]
    (packages / "dependencies.pth").write_text("\n".join(dependencies) + "\n")
    where = "import stillarm.controller, supervisor; print(stillarm.controller.__file__); print(supervisor.__file__)"
    found = run(python, "-c", where, cwd=tmp_path).stdout.split()
    assert all(Path(one).is_relative_to(packages) for one in found)
    stillarm, supervisorctl = (environment / "bin" / name for name in ("stillarm", "supervisorctl"))
    assert "diagnose" in run(stillarm, "--help", cwd=tmp_path).stdout
    model = packages / "stillarm" / "configs" / "model.toml"
    (tmp_path / "short.toml").write_text("duration_s = 2.0\n")
    words = ("simulate", "--model", model, "--scenario", "short.toml", "--seed", "1", "-o", "recording.mcap")
    run(stillarm, *words, cwd=tmp_path)
    assert (tmp_path / "recording.mcap").stat().st_size > 100_000
    assert "supervisorctl" in run(supervisorctl, "--help", cwd=tmp_path).stdout
    run(*pip, "uninstall", "--yes", "stillarm", cwd=tmp_path)
    assert not list((packages / "stillarm").rglob("*.py"))  # what was compiled there may stay
    assert "supervisorctl" in run(supervisorctl, "--help", cwd=tmp_path).stdout
