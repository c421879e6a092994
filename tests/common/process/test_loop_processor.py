import os
import subprocess
import sys
from collections.abc import Iterator

import pytest

from stillarm.common.process.loop_processor import (
    beside_the_loop,
    leave_it_to_the_loop,
    loop_processor,
    send_beside_the_loop,
)

pytestmark = pytest.mark.skipif(not hasattr(os, "sched_getaffinity"), reason="the system has no such choice")


@pytest.fixture(autouse=True)
def place() -> Iterator[set[int]]:
    """The processors of this process; restored afterwards."""
    before = os.sched_getaffinity(0)
    yield before
    os.sched_setaffinity(0, before)


@pytest.mark.slow
def test_others_leave_the_loop_its_processor(place: set[int]) -> None:
    """All but that one are left, and a child keeps to them."""
    loop = loop_processor()
    leave_it_to_the_loop()
    asked = [sys.executable, "-c", "import os; print(*sorted(os.sched_getaffinity(0)))"]
    child = subprocess.run(asked, capture_output=True, text=True, check=True).stdout.split()
    expected = place - {loop} or place
    assert os.sched_getaffinity(0) == expected == set(map(int, child))


@pytest.mark.slow
def test_a_child_that_runs_leaves_it_too(place: set[int]) -> None:
    """With a thread that it has started already; this process stays where it is, and one that is gone is no error."""
    says = (
        "import os, sys, threading; wait = threading.Event(); "
        "one = threading.Thread(target=wait.wait); one.start(); print('up', flush=True); sys.stdin.readline(); "
        "print(*sorted(os.sched_getaffinity(0)), '/', *sorted(os.sched_getaffinity(one.native_id)), flush=True); "
        "wait.set()"
    )
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", says], stdin=pipe, stdout=pipe, text=True) as child:
        assert child.stdin is not None and child.stdout is not None
        child.stdout.readline()
        send_beside_the_loop(child.pid)
        child.stdin.write("go\n")
        child.stdin.flush()
        main, other = child.stdout.readline().split("/")
    expected = place - {max(place)} or place
    assert set(map(int, main.split())) == set(map(int, other.split())) == expected
    assert os.sched_getaffinity(0) == place
    send_beside_the_loop(child.pid)


def test_a_single_processor_is_shared(place: set[int]) -> None:
    """There is no other processor."""
    os.sched_setaffinity(0, {min(place)})
    leave_it_to_the_loop()
    assert os.sched_getaffinity(0) == {min(place)}


def test_whoever_starts_them_comes_back(place: set[int]) -> None:
    """Even when starting fails."""
    with pytest.raises(ZeroDivisionError), beside_the_loop():
        assert os.sched_getaffinity(0) == (place - {max(place)} or place)
        raise ZeroDivisionError
    assert os.sched_getaffinity(0) == place


def test_a_system_without_the_choice_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing raises."""
    monkeypatch.delattr(os, "sched_getaffinity")
    leave_it_to_the_loop()
    send_beside_the_loop(os.getpid())
    with beside_the_loop():
        pass
