"""`benchmark live --kill-supervisor`: runs in which the supervisor is killed again and again, and what follows."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from stillarm.benchmarks.live.kills.kill_plan import Kill, plan
from stillarm.benchmarks.live.kills.kill_processes import run_kills
from stillarm.benchmarks.live.kills.kill_scoring import gap_around, score_kill
from stillarm.benchmarks.live.replay_tables import read_estimates
from stillarm.benchmarks.live.run import checked_methods, labelled, run_folder
from stillarm.benchmarks.live.truth import read_strikes_and_motion
from stillarm.common.recording.reader import open_recording
from stillarm.common.user_error import UserError
from stillarm.controller.replay.replay import read_run, replay_method
from stillarm.controller.replay.replay_tables import write_tables
from stillarm.simulation.demo.demo import Progress
from stillarm.simulation.demo.own_folder import own_folder

_SHORTEST_GAP_S, _LONGEST_GAP_S = 0.3, 60.0
_MOST_GAPS = 16  # a run is to fit the replay's memory


def run_all_kills(
    runs: int,
    gaps_s: list[float],
    load: int,
    seed: int,
    methods: list[str] | None,
    keep: Path | None,
    progress: Progress,
    told: Callable[[str], None] = lambda line: None,
) -> dict[str, Any]:
    """In each of `runs` runs, run k with seed `seed` + k, one kill for each gap. A row for each kill and method.

    Raises UserError for what the user can mend; a run that fails ends the benchmark.
    """
    if not 1 <= len(gaps_s) <= _MOST_GAPS or not all(_SHORTEST_GAP_S <= g <= _LONGEST_GAP_S for g in gaps_s):
        raise UserError(
            f"--kill-supervisor: 1 to {_MOST_GAPS} gaps of {_SHORTEST_GAP_S:g} to {_LONGEST_GAP_S:g} s, such as 0.3,1,3"
        )
    names = checked_methods(runs, load, methods or ["fused"])
    rows: list[dict[str, Any]] = []
    for number in range(runs):
        label = f"run {number + 1} of {runs}"
        kills, scenario = plan(gaps_s, seed + number)
        with run_folder(keep, number) as directory, own_folder(directory):
            run_kills(directory, kills, scenario, seed + number, load, labelled(progress, label))
            of_run = _scored(directory, kills, names, labelled(progress, label))
        rows += [{"run": number, "seed": seed + number, **row} for row in of_run]
        told(_line(f"{label}, seed {seed + number}", of_run))
    return {"load": load, "gaps_s": gaps_s, "rows": rows}


def _scored(directory: Path, kills: list[Kill], names: list[str], progress: Progress) -> list[dict[str, Any]]:
    recorded = read_run(open_recording(directory / "recording.mcap"))
    _, truth = read_strikes_and_motion(directory / "truth.mcap", directory / "recording.mcap")
    replays = []
    for method in names:
        with progress(method) as done:
            replays.append(replay_method(recorded, method, done))
    write_tables(replays, directory)
    said = read_estimates(directory)
    received_s = [frame.received_s for frame in recorded.frames if frame.frame >= 0]
    restarts = sum(frame.restarted for frame in recorded.frames)
    if restarts != len(kills):
        raise UserError(f"{directory}: {restarts} new supervisors were noticed, {len(kills)} were started")
    rows = []
    for kill in kills:
        gap = gap_around(kill, received_s)
        if gap is None:
            raise UserError(
                f"{directory}: no image came after the kill at {kill.at_s:.1f} s; see supervisor.log"
            )
        shared = {"killed_at_s": kill.at_s, "gap_asked_s": kill.gap_s, "gap_s": gap[1] - gap[0]}
        rows += [
            {"method": method, **shared, **score_kill(said[method], truth, kill, gap)} for method in names
        ]
    return rows


def _line(label: str, rows: list[dict[str, Any]]) -> str:
    texts = [
        f"{row['gap_s']:.2f} s: {row['settled_s']:.2f} s" if row["settled_s"] is not None else "-"
        for row in rows
        if row["method"] == rows[0]["method"]
    ]
    return f"{label}, {rows[0]['method']} settled after gaps of {'; '.join(texts)}"
