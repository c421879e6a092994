"""Packed chunk indices come out as they went in, and a recording keeps its own in them."""

from io import BytesIO
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.records import ChunkIndex
from mcap.writer import Writer

from stillarm.common.recording.chunk_indices import PackedChunkIndices
from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recording.topics import LogLine
from stillarm.common.recording.writer import _CHUNK_INDICES, RecordingWriter

WORD = st.integers(0, 2**64 - 1)
INDICES = st.builds(
    ChunkIndex,
    chunk_length=WORD,
    chunk_start_offset=WORD,
    compression=st.just("zstd"),
    compressed_size=WORD,
    message_end_time=WORD,
    message_index_length=WORD,
    message_index_offsets=st.dictionaries(st.integers(0, 2**16 - 1), WORD, max_size=9),
    message_start_time=WORD,
    uncompressed_size=WORD,
)


@pytest.mark.slow
@given(st.lists(INDICES, max_size=5))
def test_what_went_in_comes_out_in_order(indices: list[ChunkIndex]) -> None:
    packed = PackedChunkIndices()
    for index in indices:
        packed.append(index)
    assert list(packed) == indices and len(packed) == len(indices)


def test_a_recording_has_its_chunks_indexed_and_keeps_no_object_for_each(tmp_path: Path) -> None:
    """The library's own list is where they would pile up: it has to be there still, and be ours."""
    assert hasattr(Writer(BytesIO()), _CHUNK_INDICES)
    path = tmp_path / "a.mcap"
    writer = RecordingWriter(
        path,
        RecordingHeader(
            program_version="1",
            configuration="",
            configuration_name="x.toml",
            model="",
            method="",
            kind="simulated",
        ),
    )
    for k in range(40):
        writer.write("/log", LogLine(0.1 * k, "info", "a line"))
    kept = getattr(writer._writer, _CHUNK_INDICES)
    writer.close()
    assert isinstance(kept, PackedChunkIndices) and len(kept) == 8
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
        assert summary is not None and summary.chunk_indexes == list(kept)
        assert sum(1 for _ in make_reader(file).iter_messages(start_time=int(1e9), end_time=int(2e9))) == 10
