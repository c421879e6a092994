"""The chunk indices of a recording under way, packed: the package mcap keeps objects, ten megabytes of them an hour."""

import struct
from collections.abc import Iterator

from mcap.records import ChunkIndex

_FIXED = struct.Struct("<QQQQQQQH")  # times, place and lengths, sizes; then how many channels
_OFFSET = struct.Struct("<HQ")


class PackedChunkIndices:
    """Takes chunk indices as a list does, in some hundred bytes each. All have the same compression."""

    def __init__(self) -> None:
        """Empty."""
        self._packed = bytearray()
        self._count = 0
        self._compression = ""

    def append(self, index: ChunkIndex) -> None:
        """One more."""
        self._compression = index.compression
        offsets = index.message_index_offsets
        self._packed += _FIXED.pack(
            index.message_start_time,
            index.message_end_time,
            index.chunk_start_offset,
            index.chunk_length,
            index.message_index_length,
            index.compressed_size,
            index.uncompressed_size,
            len(offsets),
        )
        for channel, offset in offsets.items():
            self._packed += _OFFSET.pack(channel, offset)
        self._count += 1

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[ChunkIndex]:
        at = 0
        for _ in range(self._count):
            start, end, place, length, index_length, compressed, uncompressed, channels = _FIXED.unpack_from(
                self._packed, at
            )
            at += _FIXED.size
            pairs = _OFFSET.iter_unpack(self._packed[at : at + channels * _OFFSET.size])
            offsets = dict(pairs)
            at += channels * _OFFSET.size
            yield ChunkIndex(
                chunk_length=length,
                chunk_start_offset=place,
                compression=self._compression,
                compressed_size=compressed,
                message_end_time=end,
                message_index_length=index_length,
                message_index_offsets=offsets,
                message_start_time=start,
                uncompressed_size=uncompressed,
            )
