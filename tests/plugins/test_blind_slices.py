"""Blind cases take turns: every case comes up, once in as many runs as there are slices, and can be asked for again."""

from datetime import date

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.plugins.blind_slices import VARIABLE, slice_of, turn_from, turn_of

FILE = """
import pytest

@pytest.mark.blind(each_run=2, seed=7)
@pytest.mark.parametrize("case", range(5))
def test_blind(case):
    pass

def test_always():
    pass
"""


@given(count=st.integers(1, 60), each_run=st.integers(1, 70), first=st.integers(0, 30_000))
def test_consecutive_turns_ask_every_case_once(count: int, each_run: int, first: int) -> None:
    slices = -(-count // each_run)
    asked = [place for turn in range(first, first + slices) for place in slice_of(count, each_run, turn)]
    assert sorted(asked) == list(range(count))
    assert all(len(slice_of(count, each_run, first + k)) <= each_run for k in range(slices))


def test_turns_are_days() -> None:
    assert turn_of(date(1970, 1, 1)) == 0
    assert turn_of(date(2026, 3, 1)) == turn_of(date(2026, 2, 28)) + 1


def test_functions_of_a_group_take_turns_together(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In another file, too, and without a seed."""
    mark = "import pytest\n\n@pytest.mark.blind(each_run=1, group='same')\ndef test_it(): pass\n"
    pytester.makeini("[pytest]\nmarkers =\n    blind: takes turns")
    pytester.makepyfile(test_a=mark, test_b=mark, test_c=mark)
    ran = []
    for turn in "345":
        monkeypatch.setenv(VARIABLE, turn)
        result = pytester.runpytest_inprocess("-v", "-p", "tests.plugins.blind_slices")
        result.assert_outcomes(passed=1, deselected=2)
        assert f"blind cases: 1, slice {turn}, seed none" in result.stdout.str()
        ran += [name for name in "abc" if f"test_{name}.py::test_it" in result.stdout.str()]
    assert sorted(ran) == ["a", "b", "c"]


@pytest.mark.parametrize("text", ["", "-1", "2.5", "every"])
def test_a_slice_that_is_none_is_refused(text: str) -> None:
    assert turn_from("all") is None and turn_from("12") == 12
    with pytest.raises(pytest.UsageError, match=f"{VARIABLE} = '{text}'"):
        turn_from(text)


@pytest.mark.parametrize(
    ("slice_", "words", "passed", "told"),
    [
        ("0", [], 3, "blind cases: 2, slice 0, seed 7; again: STILLARM_SLICE=0 make test"),
        ("1", [], 3, "blind cases: 2, slice 1, seed 7"),
        ("2", [], 2, "blind cases: 1, slice 2, seed 7"),
        ("all", [], 6, "blind cases: 5, slice all"),
        ("2", ["-k", "blind"], 5, "blind cases: 5"),
        ("2", ["test_it.py::test_blind"], 5, "blind cases: 5"),
    ],
)
def test_a_run_asks_its_slice_and_says_so(
    slice_: str,
    words: list[str],
    passed: int,
    told: str,
    pytester: pytest.Pytester,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A test that is named on the command line always runs."""
    monkeypatch.setenv(VARIABLE, slice_)
    pytester.makeini("[pytest]\nmarkers =\n    blind: takes turns")
    pytester.makepyfile(test_it=FILE)
    result = pytester.runpytest_inprocess("-p", "tests.plugins.blind_slices", *words)
    result.assert_outcomes(
        passed=passed, deselected=6 - passed if not words else 6 - passed - (words[0] != "-k")
    )
    assert told in result.stdout.str()
