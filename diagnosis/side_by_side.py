"""Work on two cores: the compiled loops, and numpy in large arrays, let go of the interpreter's lock."""

from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from threading import current_thread
from typing import ParamSpec, TypeVar

_Given = ParamSpec("_Given")
_Item = TypeVar("_Item")
_Result = TypeVar("_Result")

_NAME = "diagnose-beside"
_POOL = ThreadPoolExecutor(2, thread_name_prefix=_NAME)


def side_by_side(work: Callable[[_Item], _Result], items: Iterable[_Item]) -> list[_Result]:
    """The work on each item, in order. Within work that is done so itself, one after another: it would wait for its own
    place."""
    if current_thread().name.startswith(_NAME):
        return [work(item) for item in items]
    return list(_POOL.map(work, items))


def meanwhile(
    work: Callable[_Given, _Result], *given: _Given.args, **named: _Given.kwargs
) -> Future[_Result]:
    """Begin some work beside what comes next. Not from within work that is done so itself."""
    return _POOL.submit(work, *given, **named)
