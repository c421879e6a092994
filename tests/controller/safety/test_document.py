"""docs/safety.md shows the tables as they are in the code."""

from pathlib import Path

from stillarm.controller.safety.document import adjusting_table, ground_table, transition_table

SAFETY = (Path(__file__).parents[3] / "docs" / "safety.md").read_text()


def test_the_document_holds_its_tables() -> None:
    """To the character; paste the functions' results where it does not."""
    assert transition_table() in SAFETY
    assert ground_table() in SAFETY
    assert adjusting_table() in SAFETY
