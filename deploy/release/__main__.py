"""`python deploy/release`: builds a release into dist/, with its bill of materials and the audit of what it needs.

    pip install -e '.[release]'
    git tag v0.1.0 && python deploy/release

dist/ then holds the wheel and the source distribution, the wheel `stillarm-complete`, and sbom.json. `pip install
dist/*.whl` therefore installs all that the demo needs; `pip install dist/stillarm-*.whl` only what a controller needs.
It uploads nothing. `--untagged` builds a tree that has no tag. Known vulnerabilities are looked up at PyPI and at
OSV; where neither can be asked, the release fails and says so. `--no-audit` leaves that out, and says that, too.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from audit import audit
from checks import mistakes, version_of

ROOT = Path(__file__).resolve().parents[2]
COMPLETE = """\
[build-system]
requires = ["setuptools>=80"]
build-backend = "setuptools.build_meta"

[project]
name = "stillarm-complete"
version = "{version}"
description = "stillarm with every extra: rig, demo, diagnosis, vision, hardware and file formats"
license = "Apache-2.0"
requires-python = ">=3.11"
dependencies = ["stillarm[all]=={version}"]

[tool.setuptools]
packages = []
"""


def run(*words: str | Path, cwd: Path = ROOT) -> None:
    """A step of the release; its failure ends it."""
    print("+", *words, flush=True)
    status = subprocess.run([str(word) for word in words], cwd=cwd, check=False).returncode
    if status:
        raise SystemExit(f"release: `{words[0]}` failed with status {status}; what it printed says why")


def build(version: str, dist: Path) -> None:
    """Wheel, source distribution and the wheel that needs everything."""
    run(sys.executable, "-m", "build", "--outdir", dist)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "pyproject.toml").write_text(COMPLETE.format(version=version))
        run(sys.executable, "-m", "build", "--wheel", "--outdir", dist, cwd=Path(folder))


def install(environment: Path, wheel: Path) -> Path:
    """A fresh environment with the wheel and all that a user may get with it: what is listed and audited."""
    run(sys.executable, "-m", "venv", environment)
    run(environment / "bin" / "python", "-m", "pip", "install", "--quiet", f"{wheel}[all]")
    run(environment / "bin" / "python", "-m", "pip", "uninstall", "--quiet", "--yes", "setuptools", "pip")
    return environment


def main() -> int:
    """Check, build, list what is inside, audit."""
    parser = argparse.ArgumentParser(prog="python deploy/release", description=__doc__)
    parser.add_argument(
        "--dist", type=Path, default=ROOT / "dist", metavar="DIR", help="output folder (dist)"
    )
    parser.add_argument("--untagged", action="store_true", help="build although the commit has no tag")
    parser.add_argument("--no-audit", action="store_true", help="leave out pip-audit")
    arguments = parser.parse_args()
    version = version_of(ROOT)
    if wrong := mistakes(ROOT, version, tagged=not arguments.untagged):
        print("\n".join(f"release: {one}" for one in wrong), file=sys.stderr)
        return 1
    dist = arguments.dist.resolve()
    dist.mkdir(parents=True, exist_ok=True)
    build(version, dist)
    with tempfile.TemporaryDirectory() as folder:
        installed = install(Path(folder) / "environment", next(dist.glob(f"stillarm-{version}-*.whl")))
        run("cyclonedx-py", "environment", installed / "bin" / "python", "-o", dist / "sbom.json")
        if arguments.no_audit:
            print("release: not audited (--no-audit)")
        else:
            (packages,) = (installed / "lib").glob("python*/site-packages")
            clean, lines = audit(packages)
            print("\n".join(f"release: {line}" for line in lines))
            if not clean:
                return 1
    print(f"release {version} is in {dist}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
