"""Every kind of recording times every command: an answer or one clear line, and where the answer is known, that one."""

from dataclasses import replace
from pathlib import Path

import pytest

from tests.recordings.expected import refusal
from tests.recordings.outcome import (
    BUDGET_S,
    COMMANDS,
    Outcome,
    check_diagnosis,
    diagnosis_of,
    fault_of,
    run_all,
)
from tests.recordings.shapes import HZ, SEED, SHAPES, UNIX_S, moved
from tests.recordings.table import PAGE, page

LONG = "10 min at 1 kHz"
LONG_BUDGET_S = 8.0


@pytest.mark.blind(each_run=12, seed=SEED)
@pytest.mark.parametrize("name", SHAPES)
def test_every_command_ends_in_an_answer_or_in_one_line(name: str, tmp_path: Path) -> None:
    """The longest is replayed by the quickest method: the usual one takes 45 s of processor time for it."""
    budget_s, method = (LONG_BUDGET_S, "timestamps") if name == LONG else (BUDGET_S, None)
    outcomes = run_all(SHAPES[name], tmp_path, budget_s, method=method)
    wrong = {command: fault for command, one in outcomes.items() if (fault := fault_of(one))}
    assert not wrong
    assert {command: _as_expected(name, command, one) for command, one in outcomes.items()} == dict.fromkeys(
        outcomes, ""
    )
    if outcomes["import"].status == 0:
        assert tuple(outcomes) == COMMANDS
        if outcomes["diagnose"].status == 0:
            table = diagnosis_of(tmp_path)
            check_diagnosis(table)
            assert table["looked_at"]["budget_s"] == budget_s
            for result in ("report.html", "extended.toml"):
                assert (tmp_path / "diagnosis" / result).stat().st_size > 0


def _as_expected(shape: str, command: str, outcome: Outcome) -> str:
    """Empty where the outcome is the expected one."""
    words = refusal(shape, command)
    if words is None:
        return "" if outcome.status == 0 else outcome.error
    if outcome.refused and words in outcome.error:
        return ""
    return f"expected {words!r}, got {outcome.status}: {outcome.error or outcome.out}"


def test_there_are_enough_cells() -> None:
    assert len(SHAPES) * len(COMMANDS) >= 60


def test_the_page_is_the_matrix() -> None:
    assert PAGE.read_text() == page(), "run `python -m tests.recordings.table`, and commit docs/recordings.md"


@pytest.mark.blind(each_run=2, seed=SEED)
@pytest.mark.parametrize(
    "name",
    [
        "accelerometer alone",
        "images alone",
        "strain gauge as deflection",
        "accelerometer, a third NaN",
        "images, a third NaN",
        "20 s at 100 Hz",
    ],
)
def test_a_plain_recording_shows_nothing_but_its_frequency(name: str, tmp_path: Path) -> None:
    """The model file's frequency is off by 0.8 %; everything else in it is true."""
    outcomes = run_all(SHAPES[name], tmp_path, budget_s=None, commands=["diagnose"])
    assert outcomes["diagnose"].status == 0, outcomes["diagnose"].error
    table = diagnosis_of(tmp_path)
    assert table["verdict"] == "none"
    fitted = table["baseline_changes"]["arm.modes[0].frequency_hz"]["fitted"]
    assert fitted == pytest.approx(HZ, abs=1e-3)
    assert not table["looked_at"]["left_out"]


@pytest.mark.blind(each_run=1, seed=SEED)
@pytest.mark.parametrize("base", ["images alone", "accelerometer and images"])
@pytest.mark.parametrize("start_s", [UNIX_S, -5.5])
def test_the_start_of_time_changes_nothing(start_s: float, base: str, tmp_path: Path) -> None:
    """Unix epoch seconds, or a start below zero, against the same recording from zero: one verdict, one fit, one
    delay."""
    tables, replays = {}, {}
    for by_s in (0.0, start_s):
        folder = tmp_path / str(by_s)
        folder.mkdir()
        shape = replace(SHAPES[base], change=moved(by_s))
        run_all(shape, folder, budget_s=None, commands=["replay", "diagnose"])
        tables[by_s] = diagnosis_of(folder)
        replays[by_s] = _delays(folder / "replay" / "frames.csv")
    assert tables[start_s]["verdict"] == tables[0.0]["verdict"] == "none"
    changed = {key: one["fitted"] for key, one in tables[start_s]["baseline_changes"].items()}
    usual = {key: one["fitted"] for key, one in tables[0.0]["baseline_changes"].items()}
    assert changed == pytest.approx(usual, rel=1e-4)
    for name, channel in tables[start_s]["channels"].items():
        before = tables[0.0]["channels"][name]
        assert channel["nrmse_after"] == pytest.approx(before["nrmse_after"], rel=1e-3)
    assert replays[start_s] == pytest.approx(replays[0.0], abs=1e-5)


def _delays(path: Path) -> list[float]:
    rows = [line.split(",") for line in path.read_text().splitlines()[1:]]
    return [float(row[4]) if row[4] else -1.0 for row in rows]
