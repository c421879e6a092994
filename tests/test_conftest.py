"""The run's last line, which says how many tests of measured data were left out, and why."""

import pytest

from tests.conftest import measured_data_line


@pytest.mark.parametrize(
    ("ran", "skipped", "deselected", "there", "line"),
    [
        (38, 0, 0, True, "measured data: 38 tests run, none left out"),
        (0, 38, 0, False, "measured data: 38 tests left out: ../shared/data is not there"),
        (0, 0, 38, False, "measured data: 38 tests left out: ../shared/data is not there"),
        (0, 0, 38, True, ""),
        (30, 8, 0, True, "measured data: 30 run, 8 tests left out: a part of ../shared/data is missing"),
        (0, 0, 0, True, ""),
    ],
)
def test_the_line(ran: int, skipped: int, deselected: int, there: bool, line: str) -> None:
    assert measured_data_line(ran, skipped, deselected, there) == line
