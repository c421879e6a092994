"""docs/topics.md and the overview in docs/recording.md, out of common/recording/topics.py.

`python -m stillarm.common.recording.topics_document > docs/topics.md` writes the first.
"""

from collections.abc import Iterator

from stillarm.common.datagrams.fields import field_table, markdown_table
from stillarm.common.recording.topics import TOPICS

_TITLE = """# Topics

Every message of a recording, field by field. [common/recording/topics.py](../common/recording/topics.py) declares them,
[recording.md](recording.md) tells what surrounds them, and [telemetry.md](telemetry.md) which of them are sent live. A
float may be null in the file: not measured, or not known.
"""


def overview() -> str:
    """A row for each topic."""
    rows = ((f"`{t.name}`", t.message.__name__, t.rate, t.source) for t in TOPICS)
    return markdown_table(("topic", "message", "rate", "written by"), rows)


def topics_page() -> str:
    """All of docs/topics.md: a section for each message."""
    return "\n".join([_TITLE, *_sections()])


def _sections() -> Iterator[str]:
    for message in dict.fromkeys(topic.message for topic in TOPICS):
        text = "\n".join(line.strip() for line in (message.__doc__ or "").strip().splitlines())
        yield f"## {message.__name__}\n\n{text}\n\n{field_table(message)}"


if __name__ == "__main__":
    print(topics_page(), end="")
