"""`stillarm diagnose`: finds where the simulation is wrong, why, and what a correction gains."""

import argparse
import math
import sys
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from stillarm.arguments import seconds
from stillarm.common.process.blas_threads import one_blas_thread
from stillarm.common.user_error import UserError

if TYPE_CHECKING:
    from stillarm.commands.recordings.diagnose_many import Done
    from stillarm.common.files.model import Model

_MOST_PAIRS = 100
_BUDGET_S = 60.0


def _span(text: str) -> tuple[float, float]:
    try:
        start, end = (float(part) for part in text.split(":"))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r}: write FROM_S:TO_S, such as 10:15") from None
    if not (math.isfinite(start) and math.isfinite(end) and start < end):
        raise argparse.ArgumentTypeError(f"{text!r}: FROM_S must lie before TO_S")
    return start, end


def _pairs(text: str) -> int:
    if not text.isascii() or not text.isdigit() or not 1 <= int(text) <= _MOST_PAIRS:
        raise argparse.ArgumentTypeError(f"{text!r}: a whole number from 1 to {_MOST_PAIRS}")
    return int(text)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument(
        "recordings",
        type=Path,
        nargs="+",
        metavar="REC",
        help="recordings (MCAP): those of a joint driven by torque, current or voltage are taken for one rig's and "
        "fitted together, all others are diagnosed separately",
    )
    parser.add_argument(
        "--apart", action="store_true", help="diagnose every recording separately, as of rigs that differ"
    )
    parser.add_argument(
        "--model", type=Path, metavar="FILE", help="model file (default: the recording's own)"
    )
    parser.add_argument(
        "--hold-out",
        type=_span,
        action="append",
        default=[],
        metavar="FROM_S:TO_S",
        help="time that no fit may use; repeatable (default: every third of up to thirty blocks)",
    )
    parser.add_argument(
        "--no-use",
        action="store_true",
        help="do not simulate what the controller gains by the extended model (some seconds)",
    )
    parser.add_argument(
        "--use-pairs",
        type=_pairs,
        default=1,
        metavar="N",
        help="repeat that simulation N times with independent noise, and report the spread (1)",
    )
    parser.add_argument(
        "--budget-s",
        type=seconds,
        default=_BUDGET_S,
        metavar="S",
        help="give a verdict within this many seconds, at least 10 or so; diagnosis.json lists what was left "
        f"out under looked_at ({_BUDGET_S:g})",
    )
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="several recordings: a Dask scheduler whose workers have the same files (default: this machine's cores)",
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("diagnosed"),
        metavar="DIR",
        help="folder for the results (diagnosed)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Diagnose the recordings, those of one driven rig together. Returns 1 if one could not be diagnosed."""
    one_blas_thread()
    from stillarm.common.files.model import load_model

    model = load_model(arguments.model) if arguments.model else None
    stems = [path.stem for path in arguments.recordings]
    if len(set(stems)) < len(stems):
        raise UserError(
            "diagnose: two recordings have the same name, and their folders would clash; rename one"
        )
    alone = len(arguments.recordings) == 1 and arguments.scheduler is None
    done = [_alone(arguments, model)] if alone else _side_by_side(arguments, model)
    for one in done:
        if one.failed:
            print(f"stillarm: {one.said}", file=sys.stderr)
            continue
        folder = one.job.folder
        print(f"{one.job.path}: {one.said}")
        if one.used:
            print(one.used)
        if one.has_report:
            print(f"{folder / 'report.html'} is the report; {folder / 'extended.toml'} is the extended model")
    return int(any(one.failed for one in done))


def _use_pairs(arguments: argparse.Namespace) -> int:
    return 0 if arguments.no_use else int(arguments.use_pairs)


def _alone(arguments: argparse.Namespace, model: "Model | None") -> "Done":
    """Diagnose one recording in this process, into the output folder itself."""
    from stillarm.commands.recordings.diagnose_many import Job, beside, diagnose_one
    from stillarm.progress import progress_bar

    (path,) = arguments.recordings
    job = Job(
        path, arguments.out, model, tuple(arguments.hold_out), _use_pairs(arguments), arguments.budget_s
    )
    with (
        progress_bar(f"diagnose {path.name}") as progress,
        beside() if job.use_pairs else nullcontext(map) as run_each,
    ):
        return diagnose_one(job, progress, run_each)


def _side_by_side(arguments: argparse.Namespace, model: "Model | None") -> "list[Done]":
    """Diagnose each recording into a folder of its name. The results have the order of the arguments."""
    from stillarm.commands.recordings.diagnose_many import Job, diagnose_all, executor_for
    from stillarm.commands.recordings.diagnose_rig import diagnose_together, of_one_rig
    from stillarm.progress import progress_bar

    out = arguments.out.absolute()
    jobs = [
        Job(
            path.absolute(),
            out / path.stem,
            model,
            tuple(arguments.hold_out),
            _use_pairs(arguments),
            arguments.budget_s,
        )
        for path in arguments.recordings
    ]
    rig = [] if arguments.apart else of_one_rig(jobs)
    apart = [job for job in jobs if job not in rig]
    done: list[Done] = []
    with (
        executor_for(arguments.scheduler, len(apart) + bool(rig)) as executor,
        progress_bar(f"diagnose {len(jobs)} recordings") as progress,
    ):
        together = executor.submit(diagnose_together, rig, out) if rig else None
        for one in diagnose_all(apart, executor):
            done.append(one)
            progress(len(done) / len(jobs))
        whole = together.result() if together else []
    of_all = [one for one in whole if one.job not in jobs]
    done += [one for one in whole if one.job in jobs]
    return [*of_all, *sorted(done, key=lambda one: jobs.index(one.job))]
