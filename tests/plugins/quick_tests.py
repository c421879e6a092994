"""`make check` runs the quick tests: no process, no whole diagnosis, a third of a second at most.

A test is quick unless it lies in one of FOLDERS or carries one of MARKS. So that this stays true, a test that is called
quick fails where it starts a process, by itself or by a fixture of any scope, be it in `make test` or in `make check`;
and `make check` names the functions whose cases together took over a second of processor time.
"""

import multiprocessing.process
import os
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest

MARKS = ("slow", "realtime", "blind", "hardware_data", "tutorial")
FOLDERS = ("benchmarks", "realtime")
"""Of tests/: left out whole."""
LONGEST_S = 1.0
_TESTS = Path(__file__).resolve().parents[1]
_STARTS = {"subprocess.Popen", "os.fork", "os.forkpty", "os.posix_spawn", "os.system"}
_TAKEN = "processor_s"  # travels with the report from the worker to the summary

started: list[str] = []
"""How processes were started since the test began."""
_starting_fixtures: dict[Any, str] = {}
_QUICK = pytest.StashKey[bool]()
_BEGUN_S = pytest.StashKey[float]()


def _listen(event: str, arguments: tuple[Any, ...]) -> None:
    """An audit hook: Python tells it of every process that it starts, but for those of multiprocessing."""
    del arguments
    if event in _STARTS:
        started.append(event)


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--quick`."""
    parser.addoption(
        "--quick", action="store_true", help="the quick tests only: no process, no whole diagnosis"
    )


def pytest_configure(config: pytest.Config) -> None:
    """Listen from the beginning: an audit hook cannot be taken off again."""
    del config
    sys.addaudithook(_listen)
    start = multiprocessing.process.BaseProcess.start

    def told(process: multiprocessing.process.BaseProcess) -> None:
        started.append("multiprocessing")
        start(process)

    multiprocessing.process.BaseProcess.start = told  # type: ignore[method-assign]


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Do not even import what is left out whole."""
    return True if config.getoption("--quick") and _lies_in_a_folder_left_out(collection_path) else None


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave the others out where only quick tests are asked for."""
    for item in items:
        marked = any(item.get_closest_marker(mark) for mark in MARKS)
        item.stash[_QUICK] = not marked and not _lies_in_a_folder_left_out(item.path)
    if config.getoption("--quick"):
        config.hook.pytest_deselected(items=[item for item in items if not item.stash[_QUICK]])
        items[:] = [item for item in items if item.stash[_QUICK]]


@pytest.hookimpl(wrapper=True)
def pytest_fixture_setup(fixturedef: pytest.FixtureDef[Any]) -> Iterator[None]:
    """Note which fixture started a process, for all of its users."""
    before = len(started)
    found = yield
    if len(started) > before:
        _starting_fixtures[fixturedef] = started[-1]
    return found


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Begin to count, before any fixture."""
    started.clear()
    item.stash[_BEGUN_S] = _processor_s()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Fail a test that is called quick and started a process."""
    found = yield
    item.user_properties.append((_TAKEN, _processor_s() - item.stash[_BEGUN_S]))
    if item.stash[_QUICK] and (how := _how_started(item)):
        pytest.fail(f"it starts a process ({how}): mark it @pytest.mark.slow, and make check leaves it out")
    return found


@cache
def _lies_in_a_folder_left_out(path: Path) -> bool:
    """Asked anew for each of a file's tests."""
    return any(_TESTS / folder in (path, *path.parents) for folder in FOLDERS)


def _how_started(item: pytest.Item) -> str | None:
    """How this test, or a fixture that it uses, started a process; None where neither did."""
    if started:
        return started[0]
    fixtures = [one for named in item._fixtureinfo.name2fixturedefs.values() for one in named]  # type: ignore[attr-defined]
    return next((_starting_fixtures[one] for one in fixtures if one in _starting_fixtures), None)


def _processor_s() -> float:
    """Processor time of this process and of its children that have ended, s."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """With `--quick`, name the tests that are not."""
    if not config.getoption("--quick"):
        return
    taken_s: dict[str, float] = {}
    for one in terminalreporter.getreports("passed"):
        function = one.nodeid.partition("[")[0]
        taken_s[function] = taken_s.get(function, 0.0) + dict(one.user_properties).get(_TAKEN, 0.0)
    for function, taken in taken_s.items():
        if taken > LONGEST_S:
            terminalreporter.write_line(f"{function}: {taken:.1f} s of processor time; mark it slow")
