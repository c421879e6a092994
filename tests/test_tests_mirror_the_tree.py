"""Each module has a test module of its name, or tests/tested_elsewhere.toml says which one tests it."""

import tomllib

import pytest

from tests.fixtures.mirror import ROOT, distances, mirrored, modules, own_test

TABLE = tomllib.loads((ROOT / "tests" / "tested_elsewhere.toml").read_text())
ELSEWHERE: dict[str, str] = TABLE["modules"]
BY_HAND: dict[str, str] = TABLE["by_hand"]
SPANNING: dict[str, str] = TABLE["spanning"]


def test_each_module_has_a_test_of_its_name_or_a_line_in_the_table() -> None:
    for module in modules():
        own = (ROOT / own_test(module)).exists()
        assert own + (module in ELSEWHERE) + (module in BY_HAND) == 1, (
            f"{module}: {own_test(module)} is there; take it out of tests/tested_elsewhere.toml"
            if own
            else f"{module}: write {own_test(module)}, or say in tests/tested_elsewhere.toml what tests it"
        )


def test_each_test_is_called_after_a_module_or_says_what_it_spans() -> None:
    named = {own_test(module) for module in modules()}
    for test in mirrored():
        assert (test in named) != (test in SPANNING), (
            f"{test}: no module of that name; or listed although there is one"
        )


def test_the_table_holds_nothing_that_is_gone() -> None:
    assert set(ELSEWHERE) | set(BY_HAND) <= set(modules())
    assert set(SPANNING) <= set(mirrored())


@pytest.mark.slow
def test_what_is_tested_elsewhere_is_reached_from_there() -> None:
    for module, test in ELSEWHERE.items():
        assert (ROOT / test).is_file(), f"{module}: {test} is not there"
        assert module in distances(test), f"{module}: {test} does not reach it by any import"
