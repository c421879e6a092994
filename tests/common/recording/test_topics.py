"""docs/recording.md and docs/topics.md say what the code does."""

import re
from pathlib import Path

from stillarm.common.recording.header import RecordingHeader, header_metadata
from stillarm.common.recording.topics_document import overview, topics_page

DOCS = Path(__file__).parents[3] / "docs"
TEXT = (DOCS / "recording.md").read_text(encoding="utf-8")


def test_the_tables_of_topics_and_fields_are_the_code_s() -> None:
    """To the character; common/recording/topics_document.py says how to make them anew."""
    assert overview() in TEXT
    assert (DOCS / "topics.md").read_text(encoding="utf-8") == topics_page()


def test_every_field_has_its_meaning_and_every_quantity_its_unit() -> None:
    """Counts, flags and texts have none."""
    for row in topics_page().splitlines():
        if row.startswith("| `"):
            name, kind, unit, meaning = (cell.strip() for cell in row.strip("|").split("|"))
            assert meaning, name
            assert unit or kind not in ("float", "list[float]") or name in UNITLESS, name


UNITLESS = (
    "`supervisor_clock_skew`",
    "`input`",
    "`output`",
    "`strain`",
    "`added_damping_ratio`",
    "`asked_added_damping_ratio`",
)


def test_the_header_s_keys_are_all_there() -> None:
    header = RecordingHeader(
        program_version="", configuration="", configuration_name="", model="", method="", kind="live"
    )
    section = TEXT.split("## Header")[1].split("##")[0]
    keys = {
        key
        for row in re.findall(r"^\| (`[^|]*) \|", section, flags=re.M)
        for key in re.findall("`(.*?)`", row)
    }
    assert keys == set(header_metadata(header))
