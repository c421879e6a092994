"""The documents hold the tables of messages."""

import re
from pathlib import Path

from stillarm.common.datagrams.datagram import HEAD
from stillarm.common.datagrams.messages import (
    DriveCommand,
    DriveInput,
    DriveState,
    Hello,
)
from stillarm.common.datagrams.protocol_document import message_section, message_tables

DOCS = Path(__file__).parents[3] / "docs"


def test_the_documents_hold_the_tables() -> None:
    """To the character; paste what `python -m stillarm.common.datagrams.protocol_document` prints where they do not."""
    protocol, gateway = ((DOCS / name).read_text(encoding="utf-8") for name in ("protocol.md", "gateway.md"))
    assert message_tables() in protocol
    assert re.findall(r"^\| (\w+) \| .* \|$", protocol, flags=re.M)[1:6] == list(HEAD)
    for message in (DriveCommand, DriveInput, DriveState, Hello):
        assert message_section(message) in gateway
