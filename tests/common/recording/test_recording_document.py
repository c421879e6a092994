"""docs/recording.md says what the code does."""

import re
from pathlib import Path

from common.recording.header import RecordingHeader, header_metadata
from common.recording.topics import TOPICS

TEXT = (Path(__file__).parents[3] / "docs" / "recording.md").read_text(encoding="utf-8")


def test_the_table_of_topics_is_the_code_s() -> None:
    rows = re.findall(r"^\| `(/[^`]*)` \| (\w+) \| (.*) \|$", TEXT, flags=re.M)
    assert rows == [(topic.name, topic.message.__name__, topic.rate) for topic in TOPICS]


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
