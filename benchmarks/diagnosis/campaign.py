"""Blind trials, one per two cores at a time, each kept in a separate file so that a campaign can be resumed.

`--trials N`: N recordings with one cause hidden (every cause in turn), half as many with nothing, a fifth with an
effect that the catalogue does not have, a fifth with two causes.
"""

import json
import os
import queue
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from stillarm.benchmarks.diagnosis.ask import LONGEST_S
from stillarm.benchmarks.diagnosis.hidden import hidden_world
from stillarm.benchmarks.diagnosis.picture import draw_campaign
from stillarm.benchmarks.diagnosis.summary import summary
from stillarm.benchmarks.diagnosis.warm import Lost, Warm
from stillarm.common.user_error import UserError

_CORES = 2  # that one diagnosis uses; with fewer it runs out of its time
_WORLD = "rigs"  # that the trials are drawn from
Row = dict[str, Any]
Trial = Callable[[str, int, int], Row]


def schedule(trials: int) -> list[tuple[str, int]]:
    """(kind, number) of every trial, with the kinds mixed evenly, so that an interrupted campaign covers each kind."""
    counts = {"one": trials, "none": -(-trials // 2), "unknown": -(-trials // 5), "two": -(-trials // 5)}
    all_of_them = [((k + 0.5) / count, kind, k) for kind, count in counts.items() for k in range(count)]
    return [(kind, k) for _, kind, k in sorted(all_of_them)]


def run(
    trials: int,
    seed: int,
    folder: Path | None,
    progress: Callable[[float], None] = lambda done: None,
    trial: Trial | None = None,
) -> dict[str, Any]:
    """Run or resume a campaign. Returns the content of the result file. folder: for rows and pictures.

    trial: for tests, runs one trial after another in place of the processes that make, ask and mark.
    """
    hidden_world()  # reports at once if it is missing
    if folder is not None:
        _claim(folder, trials, seed)
    plan = schedule(trials)
    rows = {key: row for key in plan if (row := _kept(folder, key)) is not None}
    missing = [key for key in plan if key not in rows]
    done = _one_by_one(missing, seed, trial) if trial else _side_by_side(missing, seed)
    for key, row in done:
        rows[key] = row
        if folder is not None:
            _keep(folder, key, row)
        progress(len(rows) / len(plan))
    result = summary([rows[key] for key in plan], trials, seed)
    if folder is not None:
        draw_campaign(result, folder)
    return result


def _one_by_one(
    keys: list[tuple[str, int]], seed: int, trial: Trial
) -> Iterator[tuple[tuple[str, int], Row]]:
    for kind, number in keys:
        yield (kind, number), trial(kind, number, seed)


def _side_by_side(keys: list[tuple[str, int]], seed: int) -> Iterator[tuple[tuple[str, int], Row]]:
    """Yield each row as it completes. In each lane, one process makes and marks trials, and another answers them."""
    if not keys:
        return
    lanes: queue.SimpleQueue[Warm] = queue.SimpleQueue()
    all_lanes = [
        Warm("stillarm.benchmarks.diagnosis.trial", own_group=True)
        for _ in range(max(1, len(os.sched_getaffinity(0)) // _CORES))
    ]
    for lane in all_lanes:
        lanes.put(lane)

    def row(key: tuple[str, int]) -> Row:
        lane = lanes.get()
        try:
            made: Row = lane.ask([*key, seed], 3.0 * LONGEST_S)
            return made
        except Lost as lost:
            raise UserError(
                f"benchmark diagnosis: trial {key[0]} {key[1]} of seed {seed} failed: {lost}; see its "
                "output above. --resume FOLDER continues with the others"
            ) from None
        finally:
            lanes.put(lane)

    pool = ThreadPoolExecutor(len(all_lanes))
    try:
        asked: dict[Future[Row], tuple[str, int]] = {pool.submit(row, key): key for key in keys}
        for future in as_completed(asked):
            yield asked[future], future.result()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for lane in all_lanes:
            lane.close()


def _kept(folder: Path | None, key: tuple[str, int]) -> Row | None:
    path = _file(folder, key) if folder is not None else None
    return json.loads(path.read_text()) if path is not None and path.is_file() else None


def _keep(folder: Path, key: tuple[str, int], row: Row) -> None:
    """Write the row completely or not at all."""
    kept = _file(folder, key)
    partly = kept.with_suffix(".part")
    partly.write_text(json.dumps(row, indent=1) + "\n")
    partly.replace(kept)


def _file(folder: Path, key: tuple[str, int]) -> Path:
    return folder / f"{key[0]}_{key[1]:04d}.json"


def _claim(folder: Path, trials: int, seed: int) -> None:
    """Note which campaign a folder contains; refuse to mix two seeds, or two worlds."""
    note = folder / "campaign.json"
    if note.is_file():
        had = json.loads(note.read_text())
        if had.get("world") != _WORLD:
            raise UserError(f"--resume {folder}: contains trials of an earlier benchmark; name a new folder")
        if had.get("seed") != seed:
            raise UserError(
                f"--resume {folder}: contains a campaign of seed {had.get('seed')}, not {seed}; "
                f"give --seed {had.get('seed')} or another folder"
            )
    elif folder.exists() and any(folder.iterdir()):
        raise UserError(f"--resume {folder}: contains other files; name a new folder, or that of a campaign")
    folder.mkdir(parents=True, exist_ok=True)
    note.write_text(json.dumps({"world": _WORLD, "seed": seed, "trials": trials}) + "\n")
