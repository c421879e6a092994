"""Work on two cores: the compiled loops, and numpy in large arrays, let go of the interpreter's lock."""

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from threading import current_thread
from typing import TypeVar

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")

_NAME = "diagnose-beside"
_POOL = ThreadPoolExecutor(2, thread_name_prefix=_NAME)


def side_by_side(work: Callable[[_Item], _Result], items: Iterable[_Item]) -> list[_Result]:
    """The work on each item, in order. Within work that is done so itself, one after another: it would wait for its own
    place."""
    if current_thread().name.startswith(_NAME):
        return [work(item) for item in items]
    given = list(items)
    contexts = [copy_context() for _ in given]  # the time limit of whoever asked
    return list(_POOL.map(lambda context, item: context.run(work, item), contexts, given))
