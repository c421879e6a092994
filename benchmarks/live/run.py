"""`benchmark live`: demos in real time, each scored for every method against its own truth."""

import shutil
import tempfile
from collections.abc import Callable, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from stillarm.benchmarks.live.beside import Floor, company
from stillarm.benchmarks.live.bound import bound_of
from stillarm.benchmarks.live.commands import judge_commands
from stillarm.benchmarks.live.misses import gaps, own_misses
from stillarm.benchmarks.live.replay_tables import read_estimates
from stillarm.benchmarks.live.scoring import score
from stillarm.benchmarks.live.truth import TrueRun, read_truth
from stillarm.common.recording.reader import open_recording
from stillarm.common.user_error import UserError
from stillarm.controller.estimation.methods import all_methods
from stillarm.controller.replay.replay import RecordedRun, read_run, replay_method
from stillarm.controller.replay.replay_tables import write_tables
from stillarm.simulation.demo.demo import Progress, run_processes
from stillarm.simulation.demo.own_folder import own_folder
from stillarm.simulation.demo.ring_down import envelope_m, settling_time_s

SHORTEST_S, LONGEST_S = 12.0, 600.0  # as for a demo
_CYCLE_S = 0.001  # of the demo's model


def run(
    runs: int,
    load: int,
    seed: int,
    duration_s: float,
    methods: Sequence[str] | None,
    keep: Path | None,
    progress: Progress,
    told: Callable[[str], None] = lambda line: None,
) -> dict[str, Any]:
    """Run so many demos with `load` busy processes beside them, run k with seed `seed` + k; the benchmark's result.

    methods: None for all. keep: a folder that keeps each run's files in RUN_k. told: is given a line after each run.
    Raises UserError for what the user can mend; a run that fails ends the benchmark.
    """
    names = checked_methods(runs, load, methods)
    if not SHORTEST_S <= duration_s <= LONGEST_S:
        raise UserError(f"--duration-s {duration_s:g}: {SHORTEST_S:g} to {LONGEST_S:g} s, as for a demo")
    rows: list[dict[str, Any]] = []
    for number in range(runs):
        label = f"run {number + 1} of {runs}"
        with run_folder(keep, number) as directory, own_folder(directory):
            of_run = _one_run(
                directory, number, seed + number, load, duration_s, names, labelled(progress, label)
            )
        rows += of_run
        told(_line(label, of_run))
    return {"load": load, "duration_s": duration_s, "rows": rows}


def checked_methods(runs: int, load: int, methods: Sequence[str] | None) -> list[str]:
    """The methods, all for None. Raises UserError for these options' values that cannot be."""
    if runs < 1:
        raise UserError(f"--runs {runs}: at least 1")
    if not 0 <= load <= 64:
        raise UserError(f"--load {load}: 0 to 64 busy processes")
    for name in methods or ():
        if name not in all_methods():
            raise UserError(f"--methods {name}: no such method; use {', '.join(all_methods())}")
    return list(methods or all_methods())


def _one_run(
    directory: Path,
    number: int,
    seed: int,
    load: int,
    duration_s: float,
    methods: list[str],
    progress: Progress,
) -> list[dict[str, Any]]:
    floor = Floor()
    scenario = run_processes(
        directory, duration_s, seed, progress, beside=lambda pid: company(pid, _CYCLE_S, load, floor)
    )
    recording = open_recording(directory / "recording.mcap")
    recorded = read_run(recording)
    truth = read_truth(directory / "truth.mcap", directory / "recording.mcap", scenario.damping[0].on_s)
    replays = []
    for method in methods:
        with progress(method) as done:
            replays.append(replay_method(recorded, method, done))
    write_tables(replays, directory)
    loop = recording.columns("/loop")
    shared = {
        "run": number,
        "seed": seed,
        "bound_mean": _bound(recorded, truth),
        "settling_time_damped_s": damped_settling_s(truth, recorded.model.arm.modes[0].frequency_hz),
        "frames": len(recorded.frames),
        "frames_lost": frames_lost([frame.frame for frame in recorded.frames if frame.frame >= 0]),
        "cycles": int(loop["cycles"][-1]),
        "deadline_misses": int(loop["deadline_misses"][-1]),
        "own_deadline_misses": own_misses(gaps([row.cycle for row in recorded.fast]), floor.gaps),
        "floor_cycles": floor.cycles,
        "floor_deadline_misses": floor.deadline_misses,
        **_commands(recorded),
    }
    said = read_estimates(directory)
    return [{"method": method, **shared, **score(said[method], truth)} for method in methods]


def _bound(recorded: RecordedRun, truth: TrueRun) -> float | None:
    time_s = np.array([row.time_s for row in recorded.fast])
    felt = np.array([row.acceleration_m_s2 for row in recorded.fast])
    return bound_of(truth, time_s, felt, recorded.model.accelerometer.scale)


def _commands(recorded: RecordedRun) -> dict[str, float | int]:
    state = {estimate.cycle: estimate.state for estimate in recorded.estimates}
    return judge_commands(
        [row.time_s for row in recorded.fast],
        [row.joint_velocity_command_rad_s for row in recorded.fast],
        [state.get(row.cycle, "") for row in recorded.fast],
        recorded.model.drive,
        recorded.cycle_s,
    )


def damped_settling_s(truth: TrueRun, frequency_hz: float) -> float | None:
    """From the second strike until the true vibration stays below 5 % of what it was; None where it never does."""
    swing, step_s = truth.swings[-1], float(truth.time_s[1] - truth.time_s[0])
    inside = (truth.time_s >= swing.begin_s) & (truth.time_s < swing.end_s)
    q = truth.deflection_m[inside]
    struck = float(np.max(np.abs(q[: max(1, round(1.0 / frequency_hz / step_s))])))
    return settling_time_s(envelope_m(q, step_s, frequency_hz), step_s, struck)


def frames_lost(counters: list[int]) -> int:
    """Frames that are missing between the first and the last that the controller read."""
    return counters[-1] - counters[0] + 1 - len(counters) if counters else 0


@contextmanager
def run_folder(keep: Path | None, number: int) -> Any:
    """A folder for one run's files: kept under `keep`, or removed afterwards."""
    if keep is not None:
        yield keep / f"run_{number}"
        return
    made = Path(tempfile.mkdtemp(prefix="stillarm-live-"))
    try:
        yield made
    finally:
        shutil.rmtree(made, ignore_errors=True)


def labelled(progress: Progress, label: str) -> Progress:
    """The same, with `label` before what it is told."""
    return lambda what: progress(f"{label}, {what}")


def _line(label: str, rows: list[dict[str, Any]]) -> str:
    best = next((row for row in rows if row["method"] == "fused"), rows[-1])
    error = "-" if best["error_mean"] is None else f"{100.0 * best['error_mean']:.2f} %"
    return (
        f"{label}, seed {best['seed']}: {best['method']} {error}, {best['frames_lost']} frames lost, "
        f"{best['deadline_misses']} deadlines missed (bare timer {best['floor_deadline_misses']})"
    )
