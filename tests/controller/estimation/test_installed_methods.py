"""A stranger's package adds a method by its metadata: listed, run and benchmarked without a change of ours."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stillarm.common.datagrams.visual_sample import TrackingStatus, VisualSample
from stillarm.common.files.configuration import Controller
from stillarm.common.files.model import Arm, Model
from stillarm.common.user_error import UserError
from stillarm.controller.estimation.installed_methods import installed_factory, installed_methods
from stillarm.controller.estimation.methods import METHODS, all_methods, check_method, make_method
from tests.fixtures.imports import ROOT
from tests.fixtures.pages import blocks

EXAMPLE = ROOT / "docs" / "examples" / "stamped_delay"
MODEL = Model(arm=Arm(length_m=2.0))


def forget() -> None:
    installed_methods.cache_clear()
    installed_factory.cache_clear()


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder on the path, for packages as pip leaves them there."""
    monkeypatch.syspath_prepend(str(tmp_path))
    forget()
    yield tmp_path
    forget()


def put(site: Path, package: str, entry: str, code: str) -> None:
    """Install a package of one module by hand: the module, and real metadata."""
    (site / f"{package}.py").write_text(code)
    about = site / f"{package}-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(f"[stillarm.methods]\n{entry}\n")


def test_an_installed_method_stands_after_ours_and_is_made_by_its_name(site: Path) -> None:
    put(
        site,
        "kept_stranger",
        "kept = kept_stranger:make",
        (EXAMPLE / "stamped_delay.py").read_text().replace("\nmethod =", "\nmake ="),
    )
    assert all_methods() == (*METHODS, "kept")
    check_method("kept")
    method = make_method("kept", MODEL, Controller(), "model.toml")
    assert type(method).__name__ == "SineMethod"


def test_a_name_of_ours_stays_ours_and_reads_no_metadata(site: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The controller makes its method again at a supervisor's restart, within a cycle."""
    put(site, "usurper", "fused = usurper:make", "raise SystemError('imported')")
    assert all_methods() == tuple(METHODS)
    monkeypatch.setattr(
        "stillarm.controller.estimation.methods.installed_methods", lambda: pytest.fail("looked")
    )
    make_method("fused", MODEL, Controller(), "model.toml")


@pytest.mark.parametrize(
    ("code", "says"),
    [
        ("import nowhere_to_be_found", "ModuleNotFoundError"),
        ("1 / 0", "ZeroDivisionError: division by zero"),
        ("x = 1", "AttributeError"),
        ("make = 3", "cannot be called"),
    ],
)
def test_a_package_that_fails_is_named_in_one_line(site: Path, code: str, says: str) -> None:
    name = f"bad_{len(code)}"
    put(site, name, f"bad = {name}:make", code)
    with pytest.raises(UserError, match=says) as error:
        make_method("bad", MODEL, Controller(), "model.toml")
    assert f"{name} 1.0" in str(error.value) and "\n" not in str(error.value)


def test_two_packages_with_one_name_are_refused_and_an_unknown_name_lists_the_installed(site: Path) -> None:
    put(site, "one_of_two", "mine = one_of_two:make", "")
    with pytest.raises(UserError, match=r"unknown; use one of .*fused, mine \(nearest: mine\)"):
        check_method("minde")
    forget()
    put(site, "two_of_two", "mine = two_of_two:make", "")
    with pytest.raises(UserError, match=r"one_of_two 1\.0 and two_of_two 1\.0"):
        all_methods()


def test_the_method_of_the_documentation_follows_the_stamps() -> None:
    """docs/how-to/method.md and the package of docs/examples: the same delays, whatever the camera's clock says."""
    (page,) = (block for block in blocks(Path("docs/how-to/method.md")) if block.kind == "python")
    spaces: list[dict[str, Any]] = [{}, {}]
    exec(page.text, spaces[0])
    exec((EXAMPLE / "stamped_delay.py").read_text(), spaces[1])
    estimators = [space["StampedDelay"](MODEL) for space in spaces]
    rng = np.random.default_rng(3)
    true_s = MODEL.timing.capture_delay_s + 0.004 * rng.standard_normal(400)
    errors = []
    for frame, delay_s in enumerate(true_s):
        cycle = 100 + 15 * frame
        exposed_s = cycle * MODEL.timing.cycle_s - delay_s
        for estimator in estimators:
            estimator.see_sample(stamped(frame, exposed_s + 12_345.678), cycle, 0.0)
        assert estimators[0].estimate.delay_s == pytest.approx(estimators[1].estimate.delay_s)
        errors.append(estimators[0].estimate.delay_s - delay_s)
    assert np.abs(errors[200:]).max() < 0.001
    estimators[1].see_sample(stamped(400, nan), 6100, 0.0)
    assert estimators[1].estimate.status == "held"


def stamped(frame: int, captured_s: float) -> VisualSample:
    """A visual sample with the camera's stamp; what it shows is of no matter here."""
    measured = (0.5, 0.0, 0.0, 0.01, 0.01, 0.0, 1e-8)
    return VisualSample(frame, 0, TrackingStatus.MEASURED, *measured, captured_s, 0.015, 100, 100)


@pytest.mark.slow
def test_a_strangers_package_runs_in_replay_benchmark_and_live(tmp_path: Path) -> None:
    """Installed by pip from its folder; ours is untouched. Live: the controller's own step in virtual time."""
    pip = (sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-build-isolation", "--no-index")
    source = tmp_path / "source"
    source.mkdir()
    for file in EXAMPLE.iterdir():
        if file.is_file():
            (source / file.name).write_text(file.read_text())
    subprocess.run([*pip, "--target", str(tmp_path / "site"), str(source)], check=True, capture_output=True)
    environment = os.environ | {"PYTHONPATH": str(tmp_path / "site")}

    def stillarm(*words: str) -> str:
        command = [sys.executable, "-m", "stillarm", *words]
        done = subprocess.run(
            command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    (tmp_path / "short.toml").write_text("duration_s = 2.0\n")
    model = str(ROOT / "configs" / "model.toml")
    live = ("--method", "stamped", "-o", "rec.mcap")
    stillarm("simulate", "--model", model, "--scenario", "short.toml", *live)
    said = stillarm("replay", "rec.mcap", "--method", "all")
    assert "stamped: " in said and "identical to the recorded run" in said
    part = ("--quick", "--trials", "1", "--regimes", "freerun constant", "--json", "rows.json")
    stillarm("benchmark", "estimators", *part, "--methods", "timestamps,stamped")
    rows = {row["method"]: row for row in json.loads((tmp_path / "rows.json").read_text())["rows"]}
    assert rows["stamped"]["delay_rms_s"] < 0.5 * rows["timestamps"]["delay_rms_s"]
    assert "stamped" in stillarm("replay", "--help")
