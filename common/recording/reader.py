"""Reads a recording back: its header, and the messages of a topic as Structs or as columns."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
from numpy.typing import NDArray

from stillarm.common.recording.container import Contents, messages, scan
from stillarm.common.recording.decoding import MessageDecoder, MessageMismatch
from stillarm.common.recording.header import METADATA_NAME, NOTES_NAME, RecordingHeader, read_header
from stillarm.common.recording.topics import TOPIC_INDEX, TOPICS
from stillarm.common.user_error import UserError


class Recording:
    """A recording on disk. Messages are read when they are asked for.

    header: what the recording says about itself
    counts: how many messages there are, by topic; topics of other programs among them
    cut: whether the end of the file is missing; what is whole before it is read
    damaged: how many stretches inside the file could not be read, and are left out
    """

    def __init__(self, path: Path, contents: Contents, header: RecordingHeader) -> None:
        """Use open_recording()."""
        self.path = path
        self.header = header
        self.cut = contents.cut
        self.damaged = contents.damaged
        self.counts: dict[str, int] = {}
        for channel in contents.channels.values():
            self.counts[channel.topic] = self.counts.get(channel.topic, 0) + channel.messages
        self._contents = contents

    @property
    def incomplete(self) -> str:
        """What of the file could not be read, in words; empty where all of it could."""
        stretches = "1 damaged stretch is" if self.damaged == 1 else f"{self.damaged} damaged stretches are"
        lost = ["its end is missing"] * self.cut + [f"{stretches} left out"] * (self.damaged > 0)
        return "; ".join(lost)

    def messages(self, topic: str) -> Iterator[Any]:
        """The topic's messages in the file's order, as Structs of its type in stillarm.common.recording.topics; null
        is NaN.

        Raises UserError, naming topic and index, when the recording has no such topic or a message does not
        fit.
        """
        decoder = self._decoder(topic)
        return self._structs(topic, decoder)

    def columns(self, topic: str) -> dict[str, NDArray[Any]]:
        """The topic's fields as arrays of one length: float64 (null is NaN), int64, bool; object for texts
        and maps.

        A list of floats is an array of shape (messages, longest list). Raises UserError as messages() does.
        """
        decoder = self._decoder(topic)
        rows: list[list[Any]] = []
        before = 0
        for block in messages(self.path, self._contents, topic):
            try:
                rows.append(decoder.rows(block))
            except MessageMismatch as error:
                raise self._misfit(topic, before, error) from None
            before += len(block)
        try:
            return decoder.columns(rows)
        except OverflowError:
            raise UserError(
                f"{self.path}: {topic}: a whole number beyond 64 bits; "
                "the file is damaged or was written by another program"
            ) from None

    def _structs(self, topic: str, decoder: MessageDecoder) -> Iterator[msgspec.Struct]:
        before = 0
        for block in messages(self.path, self._contents, topic):
            try:
                yield from decoder.structs(block)
            except MessageMismatch as error:
                raise self._misfit(topic, before, error) from None
            before += len(block)

    def _decoder(self, topic: str) -> MessageDecoder:
        present = [name for name, count in self.counts.items() if count]
        if topic not in TOPIC_INDEX or topic not in present:
            raise UserError(
                f"{self.path}: has no messages of topic {topic}; "
                f"it holds {', '.join(sorted(present)) or 'none at all'}"
            )
        encodings = {c.encoding for c in self._contents.channels.values() if c.topic == topic}
        if encodings != {"json"}:
            raise UserError(
                f"{self.path}: {topic}: message encoding {sorted(encodings)[0][:20]!r}; only 'json' is read"
            )
        return MessageDecoder(TOPICS[TOPIC_INDEX[topic]].message)

    def _misfit(self, topic: str, before: int, error: MessageMismatch) -> UserError:
        return UserError(
            f"{self.path}: {topic} message {before + error.index} (from 0) does not fit: {error}; "
            "the file is damaged or was written by another program"
        )


def open_recording(path: str | Path) -> Recording:
    """Open a recording; a cut or damaged one gives what is whole in it, and says so.

    Raises UserError for a file that cannot be read, is no MCAP file, is none of this program's, or has
    another format.
    """
    path = Path(path)
    contents = scan(path)
    if METADATA_NAME not in contents.metadata:
        state = "it is cut before its header" if contents.cut else "another program wrote it"
        raise UserError(
            f"{path}: no header of stillarm in it: {state}; measured data comes in by `stillarm import`"
        )
    header = read_header(contents.metadata[METADATA_NAME], contents.metadata.get(NOTES_NAME, {}), str(path))
    return Recording(path, contents, header)
