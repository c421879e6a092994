"""The guesses on the measured data beside the repository: nine of ten channels right, and docs/import.md says so."""

import pytest

from tests.fixtures.imports import ROOT
from tests.stillarm.tables import truth

pytestmark = [
    pytest.mark.hardware_data,
    pytest.mark.slow,
    pytest.mark.skipif(not truth.DATA.is_dir(), reason="../shared/data is not there"),
]


def test_nine_of_ten_channels_are_right_and_the_page_shows_the_table() -> None:
    rows = list(truth.rows())
    judged = [row for row in rows if row.right is not None]
    assert sum(bool(row.right) for row in judged) >= 0.9 * len(judged)
    assert truth.table(rows) in (ROOT / "docs" / "import.md").read_text(), (
        "docs/import.md: put in what `python -m tests.stillarm.tables.truth` prints"
    )


def test_what_no_source_states_is_called_unknown() -> None:
    assert [row.guess for row in truth.rows() if row.right is None] == ["unknown"] * 3
