"""A test that is called quick starts no process, whether by itself or by a fixture."""

from pathlib import Path

import pytest

FILE = """
import multiprocessing, os, subprocess, sys
import pytest

@pytest.fixture(scope="module")
def process():
    subprocess.run([sys.executable, "-c", ""], check=True)

def test_quick():
    pass

def test_popen():
    subprocess.run([sys.executable, "-c", ""], check=True)

def test_fork():
    child = os.fork()
    if child == 0:
        os._exit(0)
    os.waitpid(child, 0)

def test_multiprocessing():
    child = multiprocessing.get_context("spawn").Process(target=print)
    child.start()
    child.join()

def test_fixture(process):
    pass

def test_fixture_again(process):
    pass

@pytest.mark.slow
def test_slow(process):
    subprocess.run([sys.executable, "-c", ""], check=True)

@pytest.mark.realtime
def test_realtime():
    subprocess.run([sys.executable, "-c", ""], check=True)
"""
INI = "[pytest]\nmarkers =\n    slow: slow\n    realtime: live"
STARTING = ("test_popen", "test_fork", "test_multiprocessing", "test_fixture", "test_fixture_again")


@pytest.fixture
def inner(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    """A run of its own."""
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[2]))
    pytester.makeini(INI)
    pytester.makepyfile(test_it=FILE)
    return pytester


@pytest.mark.slow
def test_a_quick_test_that_starts_a_process_fails_and_is_told_the_mark(inner: pytest.Pytester) -> None:
    result = inner.runpytest_subprocess("-p", "tests.plugins.quick_tests", "-rf")
    result.assert_outcomes(passed=3, failed=5)
    result.stdout.fnmatch_lines_random(
        [f"FAILED test_it.py::{name} - Failed: it starts a process*" for name in STARTING]
    )


@pytest.mark.slow
def test_only_quick_ones_run_where_they_are_asked_for(inner: pytest.Pytester) -> None:
    result = inner.runpytest_subprocess("-p", "tests.plugins.quick_tests", "--quick")
    result.assert_outcomes(passed=1, failed=5, deselected=2)
