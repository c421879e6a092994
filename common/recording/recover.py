"""Mends a cut or damaged recording: a complete one with everything that is whole in it.

The package mcap has no recovery, and its readers stop at the first damage.
"""

from pathlib import Path

import msgspec

from stillarm.common.recording.reader import open_recording
from stillarm.common.recording.topics import TOPIC_INDEX
from stillarm.common.recording.writer import RecordingWriter
from stillarm.common.user_error import UserError


class RecoverReport(msgspec.Struct, frozen=True):
    """What was mended. messages: by topic. left_out: topics that are not this program's."""

    cut: bool
    damaged: int
    messages: dict[str, int]
    left_out: list[str]


def recover(path: str | Path, out_path: str | Path) -> RecoverReport:
    """Write a complete recording with the header and all whole messages of the one at `path`.

    Raises UserError when it cannot be read, holds no header, or the two are the same file.
    """
    path, out_path = Path(path), Path(out_path)
    recording = open_recording(path)
    if out_path.exists() and out_path.samefile(path):
        raise UserError(
            f"{out_path}: is the recording that is to be mended; name another file for the result"
        )
    known = [topic for topic, count in recording.counts.items() if count and topic in TOPIC_INDEX]
    writer = RecordingWriter(out_path, recording.header)
    try:
        for topic in known:
            for message in recording.messages(topic):
                writer.write(topic, message)
    finally:
        writer.close()
    return RecoverReport(
        cut=recording.cut,
        damaged=recording.damaged,
        messages={topic: recording.counts[topic] for topic in known},
        left_out=sorted(set(recording.counts) - set(TOPIC_INDEX)),
    )
