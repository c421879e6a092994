"""Work on many items, shared between this process and copies of it: all processors, without the interpreter's lock.

A copy (fork(2)) knows all that this process knows, so nothing is sent to it. Its results come back pickled in a file in
memory; of what both know, such as a world with its recording, by its place in a list alone. The items are handed out
through a pipe, one by one, to whoever is free. What a copy does not deliver, this process does itself.
"""

import gc
import os
import pickle
import signal
import struct
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from io import BytesIO
from threading import current_thread, main_thread
from typing import Any, TypeVar

from stillarm.diagnosis.physics.computing import alone, is_alone, side_by_side

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")

most_processes = 4
"""This one and its copies, each of which takes some 0.1 GB of its own. For whoever uses the processors otherwise."""
_NUMBER = struct.Struct("<H")  # of an item, in the pipe, which holds 64 KiB
_MOST_ITEMS = 30_000  # of two bytes each, so that all go into the pipe at once
_PATIENCE_S, _LOOK_S = 20.0, 0.001  # for a copy's last item, longer than any takes; how often it is asked


def shared_out(
    work: Callable[[_Item], _Result], items: Iterable[_Item], known: Sequence[object] = ()
) -> list[_Result]:
    """The work on each item, in order. known: objects that results may hold and that are to stay the same objects; the
    items are known anyway. What work changes elsewhere may be lost. In threads where no copy can be made: off Linux, or
    off the main thread, whose copy may lack what another thread holds."""
    given = list(items)
    copies = min(_processors(), most_processes, len(given)) - 1
    if copies < 1 or len(given) > _MOST_ITEMS or is_alone() or not _may_copy():
        return side_by_side(work, given)
    both = [*given, *known]
    taken, handed = os.pipe()
    os.write(handed, b"".join(_NUMBER.pack(number) for number in range(len(given))))
    os.close(handed)
    started: list[tuple[int, int]] = []
    try:
        for _ in range(copies):
            result = os.memfd_create("stillarm-copy")
            started.append((os.fork() or _copy_works(work, given, both, taken, result), result))
        found = dict(_work_off(work, given, taken))
        for copy, result in started:
            if _is_over(copy):
                found |= _read(result, both)
    finally:
        _end(started)
        os.close(taken)
    with alone():
        return [found[number] if number in found else work(item) for number, item in enumerate(given)]


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1


def _may_copy() -> bool:
    return sys.platform == "linux" and current_thread() is main_thread()


def _work_off(
    work: Callable[[_Item], _Result], given: Sequence[_Item], taken: int
) -> Iterator[tuple[int, _Result]]:
    """Items one by one, as long as there are any, each with its number. The pipe's one lock hands each to one process
    (pipe(7))."""
    with alone():
        while len(place := os.read(taken, _NUMBER.size)) == _NUMBER.size:
            number: int = _NUMBER.unpack(place)[0]
            yield number, work(given[number])


def _copy_works(
    work: Callable[[_Item], Any], given: Sequence[_Item], both: Sequence[object], taken: int, result: int
) -> int:
    """All that the copy does. It never returns: what called here is the other process's to end."""
    with suppress(BaseException):
        gc.disable()  # it would copy the pages of all that both know
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        numbers = {id(one): number for number, one in enumerate(both)}
        with os.fdopen(result, "wb", closefd=False) as file:
            for number, one in _work_off(work, given, taken):
                data = BytesIO()
                _Pickler(data, numbers).dump((number, one))
                file.write(data.getbuffer())
    os._exit(0)


class _Pickler(pickle.Pickler):
    def __init__(self, file: BytesIO, numbers: dict[int, int]) -> None:
        super().__init__(file, protocol=pickle.HIGHEST_PROTOCOL)
        self._numbers = numbers

    def persistent_id(self, obj: object) -> int | None:
        return self._numbers.get(id(obj))


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: BytesIO, both: Sequence[object]) -> None:
        super().__init__(file)
        self._both = both

    def persistent_load(self, pid: int) -> object:
        return self._both[pid]


def _is_over(copy: int) -> bool:
    """Wait for a copy's last item; False where it does not end."""
    end_s = time.monotonic() + _PATIENCE_S
    while time.monotonic() < end_s:
        with suppress(ChildProcessError):
            if os.waitpid(copy, os.WNOHANG)[0] == 0:
                time.sleep(_LOOK_S)
                continue
        return True
    return False


def _read(result: int, both: Sequence[object]) -> dict[int, Any]:
    """The results that a copy has written: its own process ended in the middle of one, if of any."""
    file = BytesIO(os.pread(result, os.fstat(result).st_size, 0))
    found = {}
    with suppress(EOFError, pickle.UnpicklingError):
        while True:
            number, one = _Unpickler(file, both).load()
            found[number] = one
    return found


def _end(started: Sequence[tuple[int, int]]) -> None:
    """No copy outlasts the work, whatever ended it."""
    for copy, result in started:
        with suppress(ProcessLookupError, ChildProcessError):
            if os.waitpid(copy, os.WNOHANG)[0] == 0:
                os.kill(copy, signal.SIGKILL)
                os.waitpid(copy, 0)
        os.close(result)
