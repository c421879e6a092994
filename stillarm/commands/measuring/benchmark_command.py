"""`stillarm benchmark`: regenerates the documentation's tables, with floors and peers for comparison."""

import argparse
import json
from pathlib import Path

from stillarm.arguments import seconds, seed
from stillarm.commands.measuring.benchmark_reports import DEFAULT_DURATION_S, REPORTS
from stillarm.common.user_error import UserError
from stillarm.progress import tell_terminal

DEFAULT_TRIALS = {
    "estimators": 20,
    "vision": 3,
    "faults": 12,
    "flood": 1,
    "soak": 1,
    "panel": 1,
    "hardware": 2,
    "diagnosis": 200,
    "commission": 20,
    "identification": 1,
    "loop": 60,
    "live": 5,
}
BENCHMARKS = tuple(DEFAULT_TRIALS)
_COUNTED = {"live": "--runs", "commission": "--rigs"}  # what its trials are called
_ONLY_FOR = {
    "out": ("estimators", "live"),
    "methods": ("estimators", "live"),
    "regimes": ("estimators",),
    "noises": ("estimators",),
    "tables": ("estimators",),
    "rows": ("estimators",),
    "quick": ("estimators",),
    "resume": ("diagnosis",),
    "load": ("live",),
    "keep": ("live",),
    "kill_supervisor": ("live",),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    defaults = ", ".join(f"{name} {trials}" for name, trials in DEFAULT_TRIALS.items())
    durations = ", ".join(f"{name} {duration_s:g}" for name, duration_s in DEFAULT_DURATION_S.items())
    parser.add_argument("name", choices=BENCHMARKS, metavar="NAME", help=f"one of: {', '.join(BENCHMARKS)}")
    parser.add_argument(
        "--trials", type=int, metavar="N", help=f"trials of each row; loop: seconds ({defaults})"
    )
    parser.add_argument(
        "--rigs", type=int, dest="trials", metavar="N", help="commission: the same as --trials"
    )
    parser.add_argument("--runs", type=int, dest="trials", metavar="N", help="live: the same as --trials")
    parser.add_argument("--load", type=int, metavar="P", help="live: busy processes during each run (0)")
    parser.add_argument(
        "--keep", type=Path, metavar="DIR", help="live: keep each run's recording, truth and tables here"
    )
    parser.add_argument(
        "--kill-supervisor",
        nargs="?",
        const="0.3,1,3,10",
        metavar="S,S",
        help="live: kill the supervisor in mid-swing instead, once a run for each gap in the images, s (0.3,1,3,10)",
    )
    parser.add_argument("--seed", type=seed, default=0, metavar="S", help="seed of the first trial (0)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the result to this file")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="estimators, live: folder for the pictures (live: live)",
    )
    parser.add_argument(
        "--resume",
        type=Path,
        metavar="FOLDER",
        help="diagnosis: keep each trial here, and continue from the trials found here",
    )
    parser.add_argument(
        "--duration-s",
        type=seconds,
        metavar="S",
        help=f"duration of the measurement, in place of trials; live: duration of each run ({durations})",
    )
    parser.add_argument(
        "--data",
        type=Path,
        metavar="DIR",
        help="identification: folder with silverbox, robot_arm, f16_vibration",
    )
    parser.add_argument("--methods", metavar="A,B", help="estimators, live: only these methods (all)")
    parser.add_argument("--regimes", metavar="A,B", help="estimators: only these regimes, such as live (all)")
    parser.add_argument(
        "--noises", metavar="A,B", help="estimators: only these noise levels of the accelerometer (all)"
    )
    parser.add_argument(
        "--tables", metavar="A,B", help="estimators: only these of estimators,damping,conditions"
    )
    parser.add_argument(
        "--rows", metavar="A,B", help='estimators: only these rows of the third table, such as "release"'
    )
    parser.add_argument(
        "--quick", action="store_true", help="estimators: only one noise level in three regimes, 12 s a trial"
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the benchmark and print its tables."""
    trials = DEFAULT_TRIALS[arguments.name] if arguments.trials is None else arguments.trials
    if trials < 1:
        raise UserError(f"{_COUNTED.get(arguments.name, '--trials')} {trials}: at least 1")
    for option, names in _ONLY_FOR.items():
        if getattr(arguments, option) not in (None, False) and arguments.name not in names:
            raise UserError(
                f"--{option.replace('_', '-')}: only for `benchmark {'`, `benchmark '.join(names)}`; leave it out"
            )
    if arguments.duration_s is not None and arguments.name not in DEFAULT_DURATION_S:
        raise UserError(f"--duration-s: only for {', '.join(DEFAULT_DURATION_S)}; leave it out")
    tell_terminal(f"benchmark {arguments.name}: loads")
    result = REPORTS[arguments.name](arguments, trials)
    of_time = arguments.name in DEFAULT_DURATION_S
    print(f"seed {arguments.seed}" if of_time else f"seed {arguments.seed}, {trials} trials")
    if arguments.json is not None:
        try:
            arguments.json.write_text(json.dumps(result, indent=2, allow_nan=False) + "\n")
        except OSError as error:
            raise UserError(
                f"--json {arguments.json}: {error.strerror}; name a file that can be written"
            ) from error
    return 0
