"""Work that is shared out among copies of the process: the same results, and none lost, whatever a copy does."""

import os
import threading
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from stillarm.diagnosis.physics import copies
from stillarm.diagnosis.physics.computing import OutOfTime, check_time, is_alone, limited
from stillarm.diagnosis.physics.copies import shared_out

pytestmark = pytest.mark.slow  # it starts processes
HERE = os.getpid()


@dataclass(frozen=True)
class Recording:
    """Something large that results refer to; no copy may send it back."""

    values: np.ndarray

    def __reduce__(self) -> str:
        raise TypeError("sent back")


@dataclass(frozen=True)
class Result:
    recording: Recording
    number: int
    process: int


@pytest.fixture(autouse=True)
def two_processors(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(copies, "_processors", lambda: 2)
    monkeypatch.setattr(copies, "most_processes", 2)


def slowly(number: int) -> int:
    time.sleep(0.01)
    return number * number


def test_results_are_in_order_and_made_in_two_processes() -> None:
    recording = Recording(np.zeros(1000))
    found = shared_out(
        lambda number: Result(recording, slowly(number), os.getpid()), range(20), known=(recording,)
    )
    assert [one.number for one in found] == [number * number for number in range(20)]
    assert all(one.recording is recording for one in found)
    assert len({one.process for one in found}) == 2 and HERE in {one.process for one in found}


def test_what_cannot_be_sent_back_is_done_here() -> None:
    found = shared_out(lambda number: (slowly(number), lambda: number), range(6))
    assert [one() for _, one in found] == list(range(6))


def children() -> set[str]:
    """The process ids of this one's children, some of which other tests may have left."""
    return set(Path(f"/proc/self/task/{os.getpid()}/children").read_text().split())


def test_a_copy_that_dies_loses_nothing() -> None:
    def work(number: int) -> int:
        if os.getpid() != HERE and number > 1:
            os.kill(os.getpid(), 9)
        return slowly(number)

    assert shared_out(work, range(8)) == [number * number for number in range(8)]


def test_a_copy_that_hangs_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(copies, "_PATIENCE_S", 0.05)

    def work(number: int) -> int:
        if os.getpid() != HERE:
            time.sleep(60.0)
        return slowly(number)

    before = children()
    assert shared_out(work, range(8)) == [number * number for number in range(8)]
    assert children() <= before


def test_an_error_reaches_whoever_asked_and_leaves_no_copy() -> None:
    def work(number: int) -> int:
        if number == 3:
            raise ValueError("three")
        return slowly(number)

    before = children()
    with pytest.raises(ValueError, match="three"):
        shared_out(work, range(6))
    assert children() <= before


def test_the_limit_of_time_holds_in_a_copy_too() -> None:
    def work(number: int) -> int:
        check_time()
        return slowly(number)

    with limited(time.monotonic() + 0.03, time.monotonic), pytest.raises(OutOfTime):
        shared_out(work, range(200))


def test_within_a_share_nothing_is_shared_out_again() -> None:
    found = shared_out(lambda number: (is_alone(), shared_out(lambda one: os.getpid(), range(4))), range(4))
    assert all(lone and len(set(processes)) == 1 for lone, processes in found)
    assert not is_alone()


def test_off_the_main_thread_no_copy_is_made() -> None:
    found: list[int] = []
    worker = threading.Thread(target=lambda: found.extend(shared_out(lambda one: os.getpid(), range(8))))
    worker.start()
    worker.join()
    assert set(found) == {HERE}
