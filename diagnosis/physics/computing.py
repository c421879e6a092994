"""How simulations are computed: side by side on two cores, and no longer than a limit.

The compiled loops, and numpy in large arrays, let go of the interpreter's lock. The limit is a context variable that
the simulation itself checks, so that no stage outlasts it: it holds for one diagnosis, also where several run in
threads of one process.
"""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar, copy_context
from threading import current_thread
from typing import Generic, TypeVar

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")
Clock = Callable[[], float]

_NAME = "diagnose-beside"
_POOL = ThreadPoolExecutor(2, thread_name_prefix=_NAME)


_alone: ContextVar[bool] = ContextVar("diagnosis_alone", default=False)


def is_alone() -> bool:
    """Whether all processors are at work already (`alone`)."""
    return _alone.get()


@contextmanager
def alone() -> Iterator[None]:
    """Within it nothing is done side by side: every processor has its own part."""
    token = _alone.set(True)
    try:
        yield
    finally:
        _alone.reset(token)


def side_by_side(work: Callable[[_Item], _Result], items: Iterable[_Item]) -> list[_Result]:
    """The work on each item, in order. Within work that is done so itself, one after another: it would wait for its own
    place."""
    given = list(items)
    if is_alone() or current_thread().name.startswith(_NAME):
        return [work(item) for item in given]
    contexts = [copy_context() for _ in given]  # the time limit of whoever asked
    return list(_POOL.map(lambda context, item: context.run(work, item), contexts, given))


class Lately(Generic[_Item, _Result]):
    """The last few results of a work, by what it was done on. Threads may share it: at worst they do the same twice."""

    def __init__(self, most: int) -> None:
        """most: results that are remembered; memory against time."""
        self._most = most
        self._known: dict[_Item, _Result] = {}

    def of(self, key: _Item, work: Callable[[], _Result]) -> _Result:
        """The result for that key, worked out unless it is remembered."""
        found = self._known.get(key)
        if found is None:
            found = work()
            last = list(self._known.items())[1 - self._most :] if self._most > 1 else []
            self._known = {**dict(last), key: found}
        return found

    def forget(self) -> None:
        """Give the memory back."""
        self._known = {}


class OutOfTime(Exception):
    """The stage's time is over. Never reaches the user: who set the limit catches it."""


_ends: ContextVar[tuple[float, Clock] | None] = ContextVar("diagnosis_ends", default=None)


@contextmanager
def limited(end_s: float | None, clock: Clock) -> Iterator[None]:
    """Within it, `check_time` raises OutOfTime once the clock is past end_s, s; None: never."""
    token = _ends.set(None if end_s is None else (end_s, clock))
    try:
        yield
    finally:
        _ends.reset(token)


@contextmanager
def limited_to(share: float) -> Iterator[None]:
    """Within it, `check_time` raises OutOfTime once this share of the time that is left is used."""
    end = _ends.get()
    if end is None:
        yield
        return
    end_s, clock = end
    now_s = clock()
    with limited(now_s + share * (end_s - now_s), clock):
        yield


def check_time() -> None:
    """Raise OutOfTime where a limit is set and has passed."""
    end = _ends.get()
    if end is not None and end[1]() > end[0]:
        raise OutOfTime
