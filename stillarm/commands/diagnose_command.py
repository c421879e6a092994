"""`stillarm diagnose`: finds where the simulation is wrong, why, and what a correction gains."""

import argparse
import json
import math
import sys
from collections.abc import Callable, Iterable
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from common.blas_threads import one_blas_thread
from common.user_error import UserError
from stillarm.arguments import seconds

if TYPE_CHECKING:
    from common.model import Model
    from diagnosis.diagnose import Diagnosis
    from stillarm.commands.diagnose_many import Done

_MOST_PAIRS = 100


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
        "recordings", type=Path, nargs="+", metavar="REC", help="recordings (MCAP), each diagnosed separately"
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
        metavar="S",
        help="give a verdict within this many seconds, at least 10 or so; diagnosis.json lists what was left "
        "out under looked_at (default: no limit)",
    )
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="several recordings: a Dask scheduler whose workers have the same files (default: this machine's cores)",
    )
    parser.add_argument(
        "--out", type=Path, default=Path("diagnosis"), metavar="DIR", help="folder for the results"
    )


def run(arguments: argparse.Namespace) -> int:
    """Diagnose each recording separately. Returns 1 if one could not be diagnosed."""
    one_blas_thread()
    from common.model import load_model

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
        print(f"{folder / 'report.html'} is the report; {folder / 'extended.toml'} is the extended model")
    return int(any(one.failed for one in done))


def _use_pairs(arguments: argparse.Namespace) -> int:
    return 0 if arguments.no_use else int(arguments.use_pairs)


def _alone(arguments: argparse.Namespace, model: "Model | None") -> "Done":
    """Diagnose one recording in this process, into the output folder itself."""
    from stillarm.commands.diagnose_many import Job, beside, diagnose_one
    from stillarm.progress import progress_bar

    (path,) = arguments.recordings
    job = Job(
        path, arguments.out, model, tuple(arguments.hold_out), _use_pairs(arguments), arguments.budget_s
    )
    with (
        beside() if job.use_pairs else nullcontext(map) as run_each,
        progress_bar(f"diagnose {path.name}") as progress,
    ):
        return diagnose_one(job, progress, run_each)


def _side_by_side(arguments: argparse.Namespace, model: "Model | None") -> "list[Done]":
    """Diagnose each recording into a folder of its name. The results have the order of the arguments."""
    from stillarm.commands.diagnose_many import Job, diagnose_all, executor_for
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
    done = []
    with (
        executor_for(arguments.scheduler, len(jobs)) as executor,
        progress_bar(f"diagnose {len(jobs)} recordings") as progress,
    ):
        for one in diagnose_all(jobs, executor):
            done.append(one)
            progress(len(done) / len(jobs))
    return sorted(done, key=lambda one: jobs.index(one.job))


def write(result: "Diagnosis", folder: Path, await_use: Callable[[], None]) -> None:
    """Write diagnosis.json, extended.toml and report.html. await_use: result of `put_to_use`.

    The verdict is written first, since the drawing of the report may be interrupted.
    """
    from diagnosis.diagnose import model_text
    from diagnosis.report.page import report_page

    (folder / "extended.toml").write_text(model_text(result.extended))
    _write_table(result, folder)
    page = report_page(result, await_use)
    _write_table(result, folder)  # now including the gain by the extended model
    (folder / "report.html").write_text(page)


def _write_table(result: "Diagnosis", folder: Path) -> None:
    text = json.dumps(_plain(result.table), indent=2, allow_nan=False) + "\n"
    (folder / "diagnosis.json").write_text(text)


def put_to_use(
    result: "Diagnosis",
    path: Path,
    model: "Model | None",
    pairs: int,
    run_each: Callable[..., Iterable[Any]],
) -> Callable[[], None]:
    """Start to simulate what the controller gains by the extended model, if that differs and can be run.

    Returns a function that waits for the simulation and adds it to the result. pairs: number of pairs of runs.
    run_each: `map`, or the `map` of an executor.
    """
    from common.configuration import load_configuration
    from common.recording.reader import open_recording
    from diagnosis.diagnose import model_of
    from diagnosis.use import begin_use
    from simulation.simulated_recording import default_simulation_configuration

    table = result.table
    if result.found.final.world.measured.pair or not (table["findings"] or table["baseline_changes"]):
        return lambda: None
    plain = model or model_of(open_recording(path))
    configuration = load_configuration(default_simulation_configuration())
    try:
        found = begin_use(plain, result.extended, configuration, pairs=pairs, run_each=run_each)
    except UserError as error:
        found = _not_simulated(error)

    def await_use() -> None:
        try:
            table["use"] = found()
        except UserError as error:
            table["use"] = _not_simulated(error)()

    return await_use


def _not_simulated(error: UserError) -> Callable[[], dict[str, Any]]:
    return lambda: {"before": None, "after": None, "note": f"not simulated: {error}"}


def _plain(value: Any) -> Any:
    """Numbers for JSON: null for values that are not finite."""
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, bool) or value is None or isinstance(value, str):
        return value
    if hasattr(value, "item"):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def sentence(table: dict[str, Any]) -> str:
    """The verdict in one sentence."""
    from diagnosis.verdict import is_sure_of

    parts = []
    for finding in table["findings"]:
        numbers = finding["parameters"].items()
        values = ", ".join(f"{name} = {one['value']:.4g} +- {one['std']:.2g}" for name, one in numbers)
        near = finding["indistinguishable_from"]
        name = " or ".join([finding["cause"], *near])
        cut = 100.0 * finding["held_out"]["reduction"]
        unsure = (
            ""
            if is_sure_of(finding, table)
            else f"hardly, with confidence {max(finding['confidence'], 0.001):.2g}: "
        )
        parts.append(f"{unsure}{name} ({values}; cuts the held-out error by {cut:.0f} %)")
    blows = f"; {len(table['events'])} impacts that no sensor measured" if table["events"] else ""
    if table["verdict"] == "none":
        return f"nothing wrong with the simulation beyond its parameters{blows}"
    if table["verdict"] == "named":
        return f"{'; then '.join(parts)}{blows}"
    left = table["unexplained"]
    low, high = left["band_hz"]
    rest = (
        f"{left['channel']} holds structure at {low:.3g} to {high:.3g} Hz that no known cause explains "
        f"(depends on: {left['dependence']})"
    )
    surely = bool(parts) and is_sure_of(table["findings"][0], table)
    return "; ".join([*parts, rest] if surely else [rest, *parts]) + blows
