"""The tables of docs/protocol.md and docs/gateway.md, out of common/datagrams/messages.py.

`python -m stillarm.common.datagrams.protocol_document` prints them.
"""

import re

from stillarm.common.datagrams.datagram import kind_of
from stillarm.common.datagrams.fields import field_table
from stillarm.common.datagrams.messages import MESSAGES, VERSION, Message


def wire_name(message: type[Message]) -> str:
    """Name of a message in the documents: DriveCommand is DRIVE_COMMAND."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "_", message.__name__).upper()


def message_tables() -> str:
    """The whole table."""
    return f"The table has version {VERSION}.\n\n" + "\n".join(map(message_section, MESSAGES))


def message_section(message: type[Message]) -> str:
    """One message with its number, who sends it, and its fields."""
    text = " ".join((message.__doc__ or "").split())
    fields = f"\n{field_table(message)}" if message.__struct_fields__ else ""
    return f"**{kind_of(message)} {wire_name(message)}**: {text}\n{fields}"


if __name__ == "__main__":
    print(message_tables())
