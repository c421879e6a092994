"""The chunk indices of a recording under way, packed: the package mcap keeps objects, ten megabytes of them an hour."""

from collections.abc import Iterator

import msgspec
from mcap.records import ChunkIndex

_ENCODE = msgspec.msgpack.Encoder().encode


class PackedChunkIndices:
    """Takes chunk indices as a list does, in less than two hundred bytes each."""

    def __init__(self) -> None:
        """Empty."""
        self._packed: list[bytes] = []

    def append(self, index: ChunkIndex) -> None:
        """One more."""
        self._packed.append(_ENCODE(tuple(vars(index).values())))

    def __len__(self) -> int:
        return len(self._packed)

    def __iter__(self) -> Iterator[ChunkIndex]:
        for packed in self._packed:
            yield ChunkIndex(*msgspec.msgpack.decode(packed))
