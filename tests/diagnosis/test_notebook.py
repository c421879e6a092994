"""`stillarm.diagnose` from Python: light until it is called, typed, and as the page says it is."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from msgspec import structs
from threadpoolctl import threadpool_info, threadpool_limits

import stillarm
from stillarm.common.user_error import UserError
from tests.fixtures.imports import ROOT
from tests.fixtures.simulated import SCENARIO, effect, record

SHORT = structs.replace(SCENARIO, duration_s=9.0, strikes=SCENARIO.strikes[:1], moves=SCENARIO.moves[:5])
"""Enough to name a gross effect: how exactly it is measured is judged elsewhere."""

HEAVY = ("numpy", "scipy", "numba", "matplotlib")


@pytest.mark.slow
def test_nothing_that_takes_seconds_is_loaded_before_the_call() -> None:
    code = f"import sys; from stillarm import Diagnosis, diagnose; print([m for m in {HEAVY} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_what_there_is_not_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'diagnosed'"):
        stillarm.diagnosed  # type: ignore[attr-defined]  # noqa: B018
    assert {"Diagnosis", "diagnose"} <= set(dir(stillarm))


def test_a_recording_that_is_not_there_is_the_users_mistake(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"none\.mcap"):
        stillarm.diagnose(tmp_path / "none.mcap")


def test_linear_algebra_is_on_one_thread_whatever_was_loaded_before(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two processes with two threads each, on two processors, wait for each other."""
    threads: list[int] = []

    def diagnosed(*_: object) -> object:
        threads.extend(one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas")
        return object()

    monkeypatch.setattr("stillarm.diagnosis.diagnose.diagnose", diagnosed)
    with threadpool_limits(2, "blas"):
        stillarm.diagnose("rec.mcap")
    assert threads and set(threads) == {1}


@pytest.mark.slow
def test_the_pages_example_does_what_it_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Numbers, and which rival comes next, may change as the search does: what is named and how it is said, may not."""
    page = (ROOT / "docs" / "diagnosis.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", page, re.S)
    (shown,) = re.findall(r"this prints\n\n((?:    .*\n)+)", page)
    record(tmp_path, effect("gravity_leakage"), scenario=SHORT).rename(tmp_path / "rec.mcap")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    exec(code, names)

    printed = capsys.readouterr().out.splitlines()
    told = [line.strip() for line in shown.splitlines()]
    assert len(printed) == len(told)
    for number in (0, 1, 4):  # but for the numbers
        assert re.sub(r"[\d.]+", "", printed[number]) == re.sub(r"[\d.]+", "", told[number])
    assert printed[2].startswith("The confidence in this is ") and told[2].startswith(
        "The confidence in this is "
    )
    assert printed[3].startswith("Mend it, or use extended.toml") and told[3].startswith(
        "Mend it, or use extended"
    )
    assert (tmp_path / "evidence.png").stat().st_size > 10_000
    found = names["found"]
    assert isinstance(found, stillarm.Diagnosis)
    assert found.verdict == "named"
    (finding,) = found.findings
    assert finding.cause == "gravity_leakage"
    assert finding.parameters["gain_m_s2_per_rad"].value == pytest.approx(9.8, rel=0.1)
    assert "gravity_leakage" in (tmp_path / "extended.toml").read_text()
    assert len(found.plot().axes) == 2
    with pytest.raises(IndexError):
        found.plot(1)
