"""A progress bar on standard error that disappears when done; nothing if that is not a terminal.

With STILLARM_PROGRESS=lines in the environment, as the panel starts its jobs, each percent is a line: `progress 0.42
LABEL`.
"""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def progress_bar(label: str) -> Iterator[Callable[[float], None]]:
    """Yield a function that accepts the fraction done, 0 to 1."""
    if os.environ.get("STILLARM_PROGRESS") == "lines":
        yield _lines(label)
        return
    if not sys.stderr.isatty():
        yield lambda done: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn(f"{label:<24}"),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bars:
        task = bars.add_task(label, total=1.0)
        yield lambda done: bars.update(task, completed=done)


def tell_terminal(line: str) -> None:
    """Write a line to standard error at once, where that is a terminal: a command's first sign of life."""
    if sys.stderr.isatty():
        print(line, file=sys.stderr, flush=True)


def _lines(label: str) -> Callable[[float], None]:
    told = -1

    def tell(done: float) -> None:
        nonlocal told
        if int(100.0 * done) > told:
            told = int(100.0 * done)
            print(f"progress {done:.2f} {label}", file=sys.stderr, flush=True)

    tell(0.0)
    return tell
