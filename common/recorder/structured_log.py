"""Log lines: one JSON object a line on standard error, for a person, for journald and for `jq` alike.

Keys: time (UTC, ISO 8601), level, process, event, and the event's other fields. Not for the cycle: what it has to say
goes through the recorder's ring as /log.
"""

import contextlib
import sys
from datetime import UTC, datetime
from typing import Any, Literal

import msgspec

from stillarm.common.files.configuration import Configuration
from stillarm.common.link.link_key import NEW_KEY
from stillarm.common.recording.header import program_version

Level = Literal["debug", "info", "warning", "error"]


def log_line(process: str, level: str, event: str, time_unix_s: float, **fields: Any) -> str:
    """The line, without its end. Field values: whatever JSON holds, structs and enumerations; NaN becomes null."""
    time = datetime.fromtimestamp(time_unix_s, UTC).isoformat(timespec="milliseconds")
    return msgspec.json.encode(
        {"time": time, "level": level, "process": process, "event": event, **fields}
    ).decode()


def log(process: str, level: Level, event: str, **fields: Any) -> None:
    """Write a line now. Never raises: the terminal may be gone."""
    with contextlib.suppress(OSError, ValueError):
        line = log_line(process, level, event, datetime.now(UTC).timestamp(), **fields)
        print(line, file=sys.stderr, flush=True)


def log_start(process: str, configuration: Configuration, configuration_path: object) -> None:
    """A daemon's first line: what runs, and with which configuration, all defaults written out; and a warning where the
    link has no key of its own.
    """
    log(
        process,
        "info",
        "started",
        version=program_version(),
        configuration_path=str(configuration_path),
        configuration=msgspec.to_builtins(configuration),
    )
    if not configuration.link.key_file:
        log(
            process,
            "warning",
            "the demo key, which everybody knows, signs the link: good for this computer alone; "
            f"for link.key_file, {NEW_KEY}",
        )
