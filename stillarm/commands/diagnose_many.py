"""One recording diagnosed, or many side by side on any executor: this machine's cores, or Dask's."""

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from os import cpu_count
from pathlib import Path
from typing import Any

from common.blas_threads import one_blas_thread
from common.model import Model
from common.user_error import UserError

_CONNECT_S = 10
_USE_S = 20.0  # that simulating what a model is worth, and the report, take on two cores


@dataclass(frozen=True)
class Job:
    """A recording to diagnose, and the folder for what comes of it. use_pairs: of runs, in which what the extended
    model is worth is simulated; 0: it is not. budget_s: for the verdict, s; none: as long as it needs."""

    path: Path
    folder: Path
    model: Model | None
    hold_out: tuple[tuple[float, float], ...]
    use_pairs: int
    budget_s: float | None = None


@dataclass(frozen=True)
class Done:
    """What came of a job: the verdict in one sentence, or what was wrong with the recording. used: what the extended
    model is worth, where that was simulated."""

    job: Job
    said: str
    failed: bool = False
    used: str = ""


def diagnose_one(
    job: Job,
    progress: Callable[[float], None] = lambda done: None,
    run_each: Callable[..., Iterable[Any]] = map,
) -> Done:
    """One job, in whatever process; what is wrong with one recording stops no other. progress takes the share done;
    run_each, as `map`, the simulations of what a model is worth.
    """
    began_s = time.monotonic()
    one_blas_thread()
    from common.output_folder import make_folder
    from diagnosis.budget import Budget
    from diagnosis.diagnose import diagnose
    from diagnosis.report.words import use_sentence
    from stillarm.commands.diagnose_command import put_to_use, sentence, write

    try:
        budget = Budget(job.budget_s, began_s)
        result = diagnose(job.path, job.model, job.hold_out, lambda done, what: progress(0.9 * done), budget)
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
    """A `map` that runs at once in two processes of its own, which get ready meanwhile; in this one where they die."""
    one_blas_thread()
    context = get_context("forkserver")
    context.set_forkserver_preload(["diagnosis.use"])  # imported once, for both
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
    """Have the first process started."""


def diagnose_all(jobs: Sequence[Job], executor: Executor) -> Iterator[Done]:
    """Every job, as they are done. Raises UserError when the executor's workers are lost."""
    futures = [executor.submit(diagnose_one, job) for job in jobs]
    for future in as_completed(futures):
        try:
            yield future.result()
        except (OSError, RuntimeError, ImportError) as error:
            raise UserError(f"diagnose: a worker was lost: {error}; is stillarm installed there?") from None


@contextmanager
def executor_for(scheduler: str | None, jobs: int) -> Iterator[Executor]:
    """Dask's at that address, else this machine's cores. Raises UserError where there is none."""
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
