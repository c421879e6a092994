"""Processes that stay: they answer, say what went wrong, and are started anew where one is lost."""

import os
import time
from pathlib import Path

import pytest

from stillarm.benchmarks.diagnosis.ask import ask
from stillarm.benchmarks.diagnosis.warm import Lost, Warm

ECHO = """
import os, sys, time
from stillarm.benchmarks.diagnosis.warm import serve

def answer(question):
    print("said on the way")
    if question == "die":
        os._exit(3)
    if question == "dawdle":
        time.sleep(60.0)
    return [question, os.getpid(), os.environ["OPENBLAS_NUM_THREADS"]]

serve(answer)
"""


@pytest.fixture
def echo(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Warm:
    (tmp_path / "echo_of_test_warm.py").write_text(ECHO)
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}{os.pathsep}{Path(__file__).resolve().parents[3]}")
    return Warm("echo_of_test_warm", own_group=True)


def test_one_process_answers_all_questions_on_one_thread(echo: Warm) -> None:
    with echo:
        first, second = echo.ask({"a": [1]}, 60.0), echo.ask("b", 60.0)
    assert first[0] == {"a": [1]} and second[0] == "b"
    assert first[1] == second[1] != os.getpid()
    assert first[2] == "1"


@pytest.mark.parametrize(
    ("question", "longest_s", "why"), [("die", 60.0, "ended"), ("dawdle", 0.2, "answer")]
)
def test_a_process_that_is_lost_is_told_of_and_replaced(
    echo: Warm, question: str, longest_s: float, why: str
) -> None:
    with echo:
        before = echo.ask(1, 60.0)[1]
        with pytest.raises(Lost, match=why):
            echo.ask(question, longest_s)
        assert echo.ask(2, 60.0)[1] != before


def test_it_ends_when_nobody_can_ask_any_more(echo: Warm) -> None:
    number = echo.ask(1, 60.0)[1]
    process = echo._process
    assert process is not None and process.stdin is not None
    process.stdin.close()
    assert process.wait(60.0) == 0 and process.pid == number
    echo._process = None


def test_a_bundle_that_cannot_be_read_is_a_miss_with_its_reason(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    began = time.monotonic()
    with Warm("stillarm.benchmarks.diagnosis.user") as user:
        asked = ask(tmp_path / "data", tmp_path, user)
    assert asked["answer"] is None and asked["error"].startswith("import: stillarm: ")
    assert time.monotonic() - began < 60.0
