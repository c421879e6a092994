"""`stillarm replay`: runs the estimators on recorded data."""

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

from stillarm.common.files.output_folder import make_folder
from stillarm.common.user_error import UserError

if TYPE_CHECKING:
    from stillarm.common.recording.reader import Recording


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    from stillarm.controller.estimation.methods import all_methods

    parser.add_argument("recording", type=Path, metavar="REC", help="recording (MCAP)")
    parser.add_argument(
        "--method",
        action="append",
        metavar="NAME",
        help=f"a method to run; repeatable: {', '.join(all_methods())}, or all (default: the recording's own)",
    )
    parser.add_argument(
        "--out", type=Path, default=Path("replay"), metavar="DIR", help="folder for the tables (replay)"
    )


def _replay_images(recording: "Recording") -> int:
    """Track the images of a supervisor's recording again."""
    from stillarm.supervisor.recorded_images import compare_with_live

    comparison = compare_with_live(recording)
    same = (
        "identical to the live tracker's, number for number"
        if comparison.different == 0
        else f"different in {comparison.different}; first: {comparison.first_difference}"
    )
    rest = (
        f"; {comparison.not_compared} images after it not compared: the recorder lost one that the tracker remembers"
        if comparison.not_compared
        else ""
    )
    print(f"supervisor, {comparison.frames} images: displacements {same}{rest}")
    return 0


def _spare_bundle(folder: Path) -> None:
    """Refuse a folder with a bundle: its measured frames.csv has the same name as the replay's table."""
    if (folder / "fast.csv").exists():
        raise UserError(
            f"{folder}: contains a CSV bundle (fast.csv), whose frames.csv would be overwritten; "
            "name another folder with --out"
        )


def run(arguments: argparse.Namespace) -> int:
    """Replay and write the tables."""
    from stillarm.common.files.effects import not_used_by_controller
    from stillarm.common.recording.reader import open_recording
    from stillarm.controller.estimation.methods import all_methods
    from stillarm.controller.replay.replay import compare_with_live, read_run, replay_method
    from stillarm.controller.replay.replay_tables import replay_summary, write_tables
    from stillarm.progress import progress_bar

    recording = open_recording(arguments.recording)
    _spare_bundle(arguments.out)
    if recording.counts.get("/images") and not recording.counts.get("/fast"):
        return _replay_images(recording)
    if recording.incomplete:
        print(f"{arguments.recording}: {recording.incomplete}")
    with progress_bar(f"reading {arguments.recording.name}"):
        recorded = read_run(recording)
    if not recorded.fast:
        raise UserError(
            f"{arguments.recording}: holds no cycles (/fast), so there is nothing to replay; "
            "record with `stillarm controller --record`, or import a bundle with a fast.csv"
        )
    if unused := not_used_by_controller(recorded.model):
        print(unused)
    names = arguments.method or [recording.header.method or recorded.configuration.controller.method]
    if "all" in names:
        names = list(all_methods())
    runs = []
    for name in dict.fromkeys(names):
        with progress_bar(f"replay, {name}") as progress:
            runs.append(replay_method(recorded, name, progress))
    with progress_bar("comparing with the recorded run, writing tables"):
        comparison = compare_with_live(recorded) if recorded.estimates else None
        make_folder(arguments.out)
        write_tables(runs, arguments.out)
    summary = replay_summary(str(arguments.recording), runs, comparison)
    (arguments.out / "summary.json").write_text(json.dumps(summary, indent=2) + "\n")
    for name, found in summary["methods"].items():
        mean = found["delay_mean_s"]
        delay = (
            "no delay estimated"
            if mean is None
            else f"delay {1e3 * mean:.1f} +- {1e3 * found['delay_std_s']:.1f} ms"
        )
        print(f"{name}: {found['frames']} frames, {delay}")
    if comparison is not None:
        same = (
            "identical to the recorded run, number for number"
            if comparison.identical
            else f"differs from the recorded run in {comparison.different} cycles; first: {comparison.first_difference}"
        )
        print(f"controller, {comparison.cycles} cycles: {same}")
    print(f"tables in {arguments.out}")
    return 0
