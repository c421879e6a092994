"""Reads the records of an MCAP file; a cut or damaged file gives everything that is whole in it.

Specification: https://mcap.dev/spec. The package mcap reads each record but the messages. Its own readers stop with an
exception at the first damage, and make an object of every message, which takes several times as long.
"""

import importlib
import struct
import zlib
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import IO, Any

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel as ChannelRecord
from mcap.records import Chunk, Metadata
from mcap.writer import MCAP0_MAGIC

from stillarm.common.user_error import UserError, reason_of

_RECORD = struct.Struct("<BQ")
_MESSAGE_HEAD = struct.Struct("<HIQQ")
_MAX_CHUNK = 1 << 29  # no writer makes larger ones: a damaged length must not take all memory


@dataclass(slots=True)
class Channel:
    """A channel: one topic with its encoding; `messages` counts what is whole."""

    topic: str
    encoding: str
    messages: int = 0


@dataclass(slots=True)
class Block:
    """A stretch of records with messages: a chunk, or a record outside of any. cut: its end is missing."""

    offset: int
    length: int
    chunk: bool
    cut: bool = False


@dataclass
class Contents:
    """What a file holds. cut: its end is missing. damaged: how many of its records could not be read."""

    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    blocks: list[Block] = field(default_factory=list)
    cut: bool = False
    damaged: int = 0


class _Damaged(Exception):
    """A record is not what its length or check sum says."""


def scan(path: Path) -> Contents:
    """Go through a whole file once. Raises UserError when it cannot be read or is no MCAP file."""
    try:
        with path.open("rb") as file:
            if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
                raise UserError(f"{path}: not an MCAP recording; `stillarm import` reads CSV")
            return _scan(file, path.stat().st_size)
    except OSError as error:
        raise UserError(f"{path}: cannot be read ({reason_of(error)}); name a recording") from None


def messages(path: Path, contents: Contents, topic: str) -> Iterator[list[bytes]]:
    """The messages of a topic, encoded, in the file's order; a list for each stretch of the file."""
    wanted = {number for number, channel in contents.channels.items() if channel.topic == topic}
    try:
        with path.open("rb") as file:
            for block in contents.blocks:
                file.seek(block.offset)
                data = file.read(block.length)
                try:
                    body = _uncompress(data, block.cut) if block.chunk else data
                except _Damaged:
                    continue
                found = [body[a:b] for number, a, b in _walk(body, {}) if number in wanted]
                if found:
                    yield found
    except OSError as error:
        raise UserError(f"{path}: cannot be read ({reason_of(error)})") from None


def _scan(file: IO[bytes], size: int) -> Contents:
    contents = Contents()
    counts: Counter[int] = Counter()
    ended = False
    offset = len(MCAP0_MAGIC)
    while not ended:
        head = file.read(_RECORD.size)
        if len(head) < _RECORD.size:
            break
        opcode, length = _RECORD.unpack(head)
        start, offset = offset + _RECORD.size, offset + _RECORD.size + length
        whole = offset <= size
        try:
            if opcode == Opcode.CHUNK:
                there = max(0, min(length, size - start))
                _note_block(
                    contents, counts, Block(start, there, chunk=True, cut=not whole), file.read(there)
                )
            elif opcode == Opcode.MESSAGE and whole:
                block = Block(start - _RECORD.size, length + _RECORD.size, chunk=False)
                _note_block(contents, counts, block, head + file.read(length))
            elif opcode == Opcode.CHANNEL and whole:
                _note_channel(file.read(length), contents.channels)
            elif opcode == Opcode.METADATA and whole:
                record = _read(Metadata, file.read(length))
                contents.metadata.setdefault(record.name, record.metadata)
            ended = opcode == Opcode.FOOTER and whole
        except _Damaged:
            contents.damaged += 1
        if not whole:
            break
        file.seek(offset)
    # only now: where a chunk is damaged, its channels stand in the summary too
    for number, count in counts.items():
        if number in contents.channels:
            contents.channels[number].messages = count
        else:
            contents.damaged += 1
    contents.cut = not ended or file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC
    return contents


def _note_block(contents: Contents, counts: Counter[int], block: Block, data: bytes) -> None:
    body = _uncompress(data, block.cut) if block.chunk else data
    counts.update([number for number, _, _ in _walk(body, contents.channels)])
    contents.blocks.append(block)


def _walk(body: bytes, channels: dict[int, Channel]) -> Iterator[tuple[int, int, int]]:
    """Channel number, start and end of each whole message in a chunk's body; adds the channels met to `channels`."""
    offset, end = 0, len(body)
    unpack, unpack_message = _RECORD.unpack_from, _MESSAGE_HEAD.unpack_from
    while offset + 9 <= end:
        opcode, length = unpack(body, offset)
        offset += 9
        if offset + length > end:
            return
        if opcode == Opcode.MESSAGE and length >= 22:
            yield unpack_message(body, offset)[0], offset + 22, offset + length
        elif opcode == Opcode.CHANNEL:
            _note_channel(body[offset : offset + length], channels)
        offset += length


def _uncompress(data: bytes, cut: bool) -> bytes:
    """The records inside a chunk record; the readable ones of a cut chunk."""
    chunk = _read(Chunk, data)
    size = chunk.uncompressed_size
    if size > _MAX_CHUNK:
        raise _Damaged
    try:
        body = _UNCOMPRESS[chunk.compression](chunk.data, size, cut)
    except (KeyError, zstandard.ZstdError, RuntimeError, EOFError, MemoryError):
        raise _Damaged from None
    sum_there = chunk.uncompressed_crc
    if not cut and (len(body) != size or (sum_there and zlib.crc32(body) != sum_there)):
        raise _Damaged
    return body


def _zstd(data: bytes, size: int, cut: bool) -> bytes:
    if zstandard.get_frame_parameters(data).window_size > _MAX_CHUNK:
        raise _Damaged
    if cut:
        return zstandard.ZstdDecompressor().decompressobj().decompress(data)
    if zstandard.frame_content_size(data) not in (size, -1):  # -1: a writer that streams does not say
        raise _Damaged
    return zstandard.ZstdDecompressor().decompress(data, max_output_size=max(1, size))


def _lz4(data: bytes, size: int, cut: bool) -> bytes:
    # only other programs' files need it; comes with the package mcap
    frame = importlib.import_module("lz4.frame")
    return bytes(frame.LZ4FrameDecompressor().decompress(data, max_length=size))


_UNCOMPRESS: dict[str, Callable[[bytes, int, bool], bytes]] = {
    "": lambda data, size, cut: data,
    "zstd": _zstd,
    "lz4": _lz4,
}


def _note_channel(data: bytes, channels: dict[int, Channel]) -> None:
    record = _read(ChannelRecord, data)
    channels.setdefault(record.id, Channel(record.topic, record.message_encoding))


def _read(kind: type[ChannelRecord | Chunk | Metadata], data: bytes) -> Any:
    """A record's fields, by the package mcap."""
    try:
        return kind.read(ReadDataStream(BytesIO(data)))
    except (McapError, struct.error, UnicodeDecodeError, OverflowError):
        raise _Damaged from None
