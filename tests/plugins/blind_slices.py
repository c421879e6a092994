"""Blind cases take turns: each run asks some of them, chosen by the date; `make campaign` asks all.

A test function marked `blind(each_run=N, seed=S)` runs N of its parametrized cases, or one less; functions marked with
the same `group="..."` take turns together. The seed is left out where nothing is drawn. The turn is the number of days
since 1970 (UTC), or STILLARM_SLICE: the number of another day runs that day's slice, `all` runs every case. A case that
guards against a past mistake does not carry the mark.
"""

import os
from collections.abc import Sequence
from datetime import UTC, date, datetime

import pytest

VARIABLE = "STILLARM_SLICE"
ALL = "all"
_EPOCH = date(1970, 1, 1)
_SEED = "blind_seed"  # travels with the report from the worker to the summary


def turn_of(day: date) -> int:
    """The turn of a day: consecutive days have consecutive turns."""
    return (day - _EPOCH).days


def slice_of(count: int, each_run: int, turn: int) -> range:
    """Places, out of `count`, whose turn it is: at most `each_run` of them.

    ceil(count / each_run) consecutive turns together hold every place exactly once.
    """
    slices = -(-count // each_run)
    return range(turn % slices, count, slices)


def turn_from(text: str) -> int | None:
    """The turn that STILLARM_SLICE states; None for all cases. Raises pytest.UsageError."""
    if text == ALL:
        return None
    if not (text.isascii() and text.isdecimal()):
        raise pytest.UsageError(f"{VARIABLE} = {text!r}: give a whole number of at least 0, or {ALL!r}")
    return int(text)


def is_named(config: pytest.Config) -> bool:
    """Whether the command line picks single tests, which then always run."""
    return bool(config.option.keyword) or any("::" in word for word in config.args)


def pytest_configure(config: pytest.Config) -> None:
    """Fix the turn once: workers inherit it, so that all agree although midnight passes."""
    del config
    os.environ.setdefault(VARIABLE, str(turn_of(datetime.now(UTC).date())))
    turn_from(os.environ[VARIABLE])


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Deselect the blind cases whose turn it is not. Begin with the others: they are long, and one that ran last would
    leave the other worker with nothing to do."""
    turn = None if is_named(config) else turn_from(os.environ[VARIABLE])
    left_out: set[pytest.Item] = set()
    for cases in _blind(items):
        mark = cases[0].get_closest_marker("blind")
        assert mark is not None
        for case in cases:
            case.user_properties.append((_SEED, str(mark.kwargs.get("seed", ""))))
        if turn is not None:
            mine = slice_of(len(cases), mark.kwargs["each_run"], turn)
            left_out |= {case for place, case in enumerate(cases) if place not in mine}
    config.hook.pytest_deselected(items=[item for item in items if item in left_out])
    ours = [item for item in items if item not in left_out]
    items[:] = sorted(ours, key=lambda item: item.get_closest_marker("blind") is None)


def _blind(items: Sequence[pytest.Item]) -> list[list[pytest.Item]]:
    """The blind cases of each test function or group, in the order of collection."""
    together: dict[str, list[pytest.Item]] = {}
    for item in items:
        mark = item.get_closest_marker("blind")
        if mark is not None:
            name = mark.kwargs.get("group", item.nodeid.partition("[")[0])
            together.setdefault(name, []).append(item)
    return list(together.values())


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say which blind cases ran, from which seeds, and how to run them, or all, again."""
    finished = [one for found in terminalreporter.stats.values() for one in found]
    called = [one for one in finished if isinstance(one, pytest.TestReport) and one.when == "call"]
    seeds = [value for one in called for name, value in one.user_properties if name == _SEED]
    if seeds:
        turn, named = os.environ[VARIABLE], "; ".join(sorted(set(seeds) - {""})) or "none"
        terminalreporter.write_line(
            f"blind cases: {len(seeds)}, slice {turn}, seed {named}; again: {VARIABLE}={turn} make test; "
            "all: make campaign"
        )
