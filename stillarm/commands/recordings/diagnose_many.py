"""Diagnoses one recording, or many in parallel on an executor: this machine's cores, or Dask."""

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from os import cpu_count
from pathlib import Path
from typing import Any

from stillarm.common.files.model import Model
from stillarm.common.process.blas_threads import one_blas_thread
from stillarm.common.user_error import UserError

_CONNECT_S = 10
_LOADED_WITHIN_S = 2.0  # longer than loading what is compiled takes
_USE_S = 20.0  # duration of the gain's simulation and of the report on two cores


@dataclass(frozen=True)
class Job:
    """A recording to diagnose, and the folder for the results.

    use_pairs: pairs of runs that simulate the gain by the extended model; 0: none. budget_s: time for the verdict,
    s; None: no limit.
    """

    path: Path
    folder: Path
    model: Model | None
    hold_out: tuple[tuple[float, float], ...]
    use_pairs: int
    budget_s: float | None = None


@dataclass(frozen=True)
class Done:
    """Result of a job: the verdict in one sentence, or the error in the recording.

    used: the gain by the extended model, if it was simulated. has_report: whether a report was written beside it.
    """

    job: Job
    said: str
    failed: bool = False
    used: str = ""
    has_report: bool = True


def diagnose_one(
    job: Job,
    progress: Callable[[float], None] = lambda done: None,
    run_each: Callable[..., Iterable[Any]] = map,
) -> Done:
    """Run one job in the calling process. An error in the recording is returned, so that it stops no other job.

    progress: receives the fraction done. run_each: `map` or the like, for the simulations of the gain.
    """
    began_s = time.monotonic()
    one_blas_thread()
    from stillarm.diagnosis.physics.ahead import compile_ahead

    compiling_s = compile_ahead()
    if compiling_s > _LOADED_WITHIN_S:  # once after an installation: no time of this diagnosis
        began_s += compiling_s
    from stillarm.commands.recordings.diagnose_result import put_to_use, sentence, write, write_driven
    from stillarm.common.files.output_folder import make_folder
    from stillarm.diagnosis.decision.budget import Budget
    from stillarm.diagnosis.diagnose import diagnose
    from stillarm.diagnosis.driven.diagnosed import DrivenResult
    from stillarm.diagnosis.report.words import use_sentence

    try:
        budget = Budget(job.budget_s, began_s)
        result = diagnose(job.path, job.model, job.hold_out, lambda done, what: progress(0.9 * done), budget)
        if isinstance(result, DrivenResult):
            write_driven(result, make_folder(job.folder))
            return Done(job, sentence(result.table))
        worth = job.use_pairs > 0
        if worth and budget.left_s is not None and budget.left_s < _USE_S:
            result.table["looked_at"]["left_out"].append("use")
            worth = False
        await_use = (
            put_to_use(result, job.path, job.model, job.use_pairs, run_each) if worth else lambda: None
        )
        write(result, make_folder(job.folder), await_use)
    except UserError as error:
        return Done(job, str(error), failed=True)
    used = result.table.get("use")
    return Done(job, sentence(result.table), used=use_sentence(used) if used else "")


@contextmanager
def beside() -> Iterator[Callable[..., Iterable[Any]]]:
    """A `map` that runs in two separate processes, which start in the background; in this process if those die."""
    one_blas_thread()
    context = get_context("forkserver")
    context.set_forkserver_preload(["stillarm.diagnosis.report.use"])  # imported once, for both
    with ProcessPoolExecutor(2, mp_context=context) as pool:

        def run_each(work: Callable[[Any], Any], items: Iterable[Any]) -> Iterable[Any]:
            given = list(items)
            try:
                begun = [pool.submit(work, item) for item in given]
            except BrokenExecutor:
                return map(work, given)
            return (_answer(future, work, item) for future, item in zip(begun, given, strict=True))

        pool.submit(_get_ready)
        yield run_each


def _answer(future: Future[Any], work: Callable[[Any], Any], item: Any) -> Any:
    try:
        return future.result()
    except BrokenExecutor:
        return work(item)


def _get_ready() -> None:
    """Do nothing: submitting this starts the first process."""


def diagnose_all(jobs: Sequence[Job], executor: Executor) -> Iterator[Done]:
    """Run every job; yields each result as it completes. Raises UserError if the executor's workers are lost."""
    futures = [executor.submit(diagnose_one, job) for job in jobs]
    for future in as_completed(futures):
        try:
            yield future.result()
        except (OSError, RuntimeError, ImportError) as error:
            raise UserError(f"diagnose: a worker was lost: {error}; is stillarm installed there?") from None


@contextmanager
def executor_for(scheduler: str | None, jobs: int) -> Iterator[Executor]:
    """The executor of the Dask scheduler at that address, or of this machine's cores. UserError if none answers."""
    if scheduler is None:
        with ProcessPoolExecutor(min(jobs, cpu_count() or 1), mp_context=get_context("spawn")) as pool:
            yield pool
        return
    try:
        from distributed import Client
    except ImportError:
        raise UserError("--scheduler: needs Dask's distributed: pip install 'stillarm[cluster]'") from None
    try:
        connect: Any = Client
        client = connect(scheduler, timeout=_CONNECT_S)
    except (OSError, ValueError) as error:
        raise UserError(
            f"--scheduler {scheduler}: no Dask scheduler answers there ({error}); start one with `dask scheduler`"
        ) from None
    try:
        yield client.get_executor()
    finally:
        client.close()
