"""What the page gets is what was measured, to float32, in the layout that page/samples.js reads."""

import struct

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from stillarm.panel.live.packing import ESTIMATE_COLUMNS, FAST_COLUMNS, KINDS, pack_rows, packed
from stillarm.panel.live.telemetry import Estimate, Fast, Row, Words

numbers = st.floats(allow_nan=False, width=32)


@given(st.integers(0, 2), st.lists(st.tuples(numbers, numbers, numbers), max_size=20))
def test_a_message_holds_its_times_and_columns(kind: int, rows: list[tuple[float, float, float]]) -> None:
    times, *columns = [[row[i] for row in rows] for i in range(3)]
    message = packed(kind, times, columns)
    got_kind, got_columns, count = struct.unpack_from("<BBH", message)
    assert (got_kind, got_columns, count) == (kind, 2, len(rows))
    assert np.frombuffer(message, "<f8", count, 8).tolist() == times
    values = np.frombuffer(message, "<f4", 2 * count, 8 + 8 * count).reshape(2, count)
    assert values.tolist() == columns
    assert len(message) == 8 + count * (8 + 2 * 4)


def test_rows_are_sorted_by_topic_and_words_are_left_out() -> None:
    rows = [
        Row(0.001, fast=Fast(1.0)),
        Row(0.001, estimate=Estimate(0.5)),
        Row(0.002, fast=Fast(2.0)),
        Row(0.002, words=Words("armed")),
    ]
    fast, estimate = pack_rows(rows)
    assert struct.unpack_from("<BBH", fast) == (0, len(FAST_COLUMNS), 2)
    assert struct.unpack_from("<BBH", estimate) == (1, len(ESTIMATE_COLUMNS), 1)
    assert pack_rows([]) == []
    assert [topic for topic, _ in KINDS] == ["fast", "estimate", "frames"]
