"""Blind trials, one after the other, each kept in a file of its own so that a campaign can be resumed.

`--trials N`: N recordings with one cause hidden (every cause in turn), half as many with nothing, a fifth with an
effect that the catalogue does not have, a fifth with two causes.
"""

import json
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.diagnosis.ask import ask
from benchmarks.diagnosis.hidden import Prepare, hidden_world
from benchmarks.diagnosis.mark import mark
from benchmarks.diagnosis.picture import draw_confusion
from benchmarks.diagnosis.summary import summary
from common.user_error import UserError

Ask = Callable[[Path, Path, list[list[float]]], dict[str, Any]]


def schedule(trials: int) -> list[tuple[str, int]]:
    """(kind, number) of every trial, the kinds mixed evenly, so that a campaign cut short says something of each."""
    counts = {"one": trials, "none": -(-trials // 2), "unknown": -(-trials // 5), "two": -(-trials // 5)}
    all_of_them = [((k + 0.5) / count, kind, k) for kind, count in counts.items() for k in range(count)]
    return [(kind, k) for _, kind, k in sorted(all_of_them)]


def run(
    trials: int,
    seed: int,
    folder: Path | None,
    progress: Callable[[float], None] = lambda done: None,
    prepare: Prepare | None = None,
    answer: Ask = ask,
) -> dict[str, Any]:
    """Run, or go on with, a campaign; returns the content of the result file. folder: keeps rows and the picture."""
    prepare = prepare or hidden_world()
    if folder is not None:
        _claim(folder, trials, seed)
    plan, rows = schedule(trials), []
    for place, (kind, number) in enumerate(plan):
        kept = folder / f"{kind}_{number:04d}.json" if folder is not None else None
        if kept is not None and kept.is_file():
            rows.append(json.loads(kept.read_text()))
        else:
            rows.append(_trial(kind, number, seed, prepare, answer))
            if kept is not None:
                partly = kept.with_suffix(".part")
                partly.write_text(json.dumps(rows[-1], indent=1) + "\n")
                partly.replace(kept)
        progress((place + 1) / len(plan))
    result = summary(rows, trials, seed)
    if folder is not None:
        draw_confusion(result["confusion"], folder / "confusion.png")
    return result


def _trial(kind: str, number: int, seed: int, prepare: Prepare, answer: Ask) -> dict[str, Any]:
    """Make, ask, mark. The bundle's folder has the same name whatever it holds, and is gone afterwards."""
    work = Path(tempfile.mkdtemp(prefix="stillarm_trial_"))
    try:
        truth = prepare(kind, number, seed, work / "data") | {"number": number}
        return mark(truth, answer(work / "data", work, truth["hold_out"]))
    finally:
        shutil.rmtree(work, ignore_errors=True)


def _claim(folder: Path, trials: int, seed: int) -> None:
    """Note which campaign a folder holds; refuse to mix two seeds."""
    note = folder / "campaign.json"
    if note.is_file():
        had = json.loads(note.read_text())
        if had.get("seed") != seed:
            raise UserError(
                f"--resume {folder}: holds a campaign of seed {had.get('seed')}, not {seed}; "
                f"give --seed {had.get('seed')} or another folder"
            )
    elif folder.exists() and any(folder.iterdir()):
        raise UserError(f"--resume {folder}: holds other files; name a new folder, or that of a campaign")
    folder.mkdir(parents=True, exist_ok=True)
    note.write_text(json.dumps({"seed": seed, "trials": trials}) + "\n")
