"""The page of constants holds every number of the diagnosis, each with what it is."""

import sys
from functools import cache
from pathlib import Path

import pytest

from tests.fixtures.imports import ROOT

sys.path.insert(0, str(ROOT / "docs" / "generator"))

import constants_page


@cache
def constants() -> list[constants_page.Constant]:
    """Of the program as it is: each reading of it takes a quarter of a second."""
    return list(constants_page.constants())


def test_every_constant_says_what_it_is() -> None:
    silent = [f"{one.module}: {one.name}" for one in constants() if not one.about]
    assert silent == []


@pytest.mark.parametrize("package", constants_page.PACKAGES)
def test_every_package_is_looked_through(package: str) -> None:
    assert any(one.module.startswith(f"diagnosis/{package}/") for one in constants())


def test_a_module_is_read_as_it_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(constants_page, "_ROOT", tmp_path)
    for package in constants_page.PACKAGES:
        (tmp_path / "diagnosis" / package).mkdir(parents=True)
    (tmp_path / "diagnosis" / "data" / "one.py").write_text(
        "Array = NDArray[float]\n_NAME = 'text'\n_POOL = Pool(2)\n"
        "A_S, B = 0.5, 3  # s; of the swing\n# of noise\nLEVEL = {'x': 0.1}\nFAR = (\n    2.0  # px\n)\n"
        "ODDS = 3.0\n'''Odds of\n20 to 1.'''\n"
    )
    found = [(one.name, one.value, one.about) for one in constants_page.constants()]
    assert found == [
        ("A_S", "0.5", "s; of the swing"),
        ("B", "3", "s; of the swing"),
        ("LEVEL", "{'x': 0.1}", "of noise"),
        ("FAR", "2.0", "px"),
        ("ODDS", "3.0", "Odds of 20 to 1."),
    ]
    assert "5 of them" in constants_page.page()
