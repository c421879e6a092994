"""Each command on one recording, in this process, and whether what came of it is an answer or a refusal."""

import contextlib
import io
import json
import math
import traceback
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stillarm.main import main
from tests.recordings.shapes import MODEL, Shape, write

COMMANDS = ("import", "replay", "calibrate", "diagnose", "export", "recover")
BUDGET_S = 2.0  # of a diagnosis: the shapes whose answer is judged take as long as they need


@dataclass(frozen=True)
class Outcome:
    """Result of a command. status: exit status, None for a traceback; out, error: what it wrote."""

    status: int | None
    out: str
    error: str

    @property
    def refused(self) -> bool:
        """Whether it ended in one line that says what is wrong."""
        return self.status in (1, 2)


def call(arguments: list[str]) -> Outcome:
    """Run a command line. An exception that would be a traceback is kept as one."""
    out, error = io.StringIO(), io.StringIO()
    status: int | None
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(error):
            status = main(arguments)
    except SystemExit as stop:
        status = stop.code if isinstance(stop.code, int) else None
    except Exception:  # every one is a fault of the program, and reported with the cell
        status = None
        error.write(traceback.format_exc())
    return Outcome(status, out.getvalue(), error.getvalue())


def run_all(
    shape: Shape,
    folder: Path,
    budget_s: float | None = BUDGET_S,
    commands: Collection[str] = COMMANDS,
    method: str | None = None,
) -> dict[str, Outcome]:
    """The import, then those of the commands in turn; without a recording only the import's outcome.

    budget_s: of the diagnosis, None for its usual one. method: that is replayed, None for the recording's own.
    """
    recording = folder / "recording.mcap"
    arguments = write(shape, folder / "data")
    found = {"import": call([*arguments, "-o", str(recording)])}
    if not recording.exists():
        return found
    model = folder / "model.toml"
    model.write_text(shape.model or MODEL)
    name = str(recording)
    limit = [] if budget_s is None else ["--budget-s", str(budget_s)]
    replayed = [] if method is None else ["--method", method]
    for command, words in {
        "replay": [name, *replayed, "--out", str(folder / "replay")],
        "calibrate": [name, "--model", str(model), "-o", str(folder / "calibrated.toml")],
        "diagnose": [name, "--no-use", *limit, "--out", str(folder / "diagnosis")],
        "export": [name, "-o", str(folder / "export")],
        "recover": [name, "-o", str(folder / "recovered.mcap")],
    }.items():
        if command in commands:
            found[command] = call([command, *words])
    return found


def fault_of(outcome: Outcome) -> str | None:
    """Why an outcome is neither an answer nor a refusal; None where it is one."""
    error = outcome.error
    if outcome.status is None or "Traceback" in error:
        return f"a traceback: {error[-400:]}"
    if outcome.status == 0:
        return f"an answer with noise on standard error: {error}" if error else _silent(outcome)
    if not outcome.refused:
        return f"exit status {outcome.status}"
    lines = error.strip().splitlines()
    if len(lines) != 1 or not lines[0].startswith("stillarm"):
        return f"not one line: {error!r}"
    says, _, remedy = lines[0].rpartition(";")
    return None if says and len(remedy.split()) >= 3 else f"no remedy: {lines[0]}"


def _silent(outcome: Outcome) -> str | None:
    return None if outcome.out.strip() else "nothing was said"


def diagnosis_of(folder: Path) -> dict[str, Any]:
    """diagnosis.json, read strictly: NaN and Infinity are no JSON."""

    def refuse(text: str) -> Any:
        raise AssertionError(f"diagnosis.json holds {text}")

    text = (folder / "diagnosis" / "diagnosis.json").read_text()
    table: dict[str, Any] = json.loads(text, parse_constant=refuse)
    return table


def check_diagnosis(table: dict[str, Any]) -> None:
    """Whether a table follows the contract: finite numbers, and a verdict that agrees with the findings."""
    assert table["verdict"] in ("named", "none", "unexplained")
    assert (table["unexplained"] is not None) == (table["verdict"] == "unexplained")
    if table["verdict"] == "named":
        assert table["findings"]
    assert table["channels"]
    for name, channel in table["channels"].items():
        assert channel["samples"] > 0, name
        for key in ("nrmse_before", "nrmse_after", "noise_floor"):
            assert channel[key] is not None and math.isfinite(channel[key]), (name, key)
    for change in table["baseline_changes"].values():
        assert all(value is not None for value in change.values())
    for finding in table["findings"]:
        assert 0.0 <= finding["confidence"] <= 1.0
        assert all(one["value"] is not None for one in finding["parameters"].values())
    looked = table["looked_at"]
    assert looked["seconds"] > 0.0 and isinstance(looked["left_out"], list)
