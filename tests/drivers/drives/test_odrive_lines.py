"""An ODrive's lines are found after any garbage, and at most one line is kept."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stillarm.drivers.drives.odrive_lines import LineReader, checked_line, line_text

pytestmark = pytest.mark.usefixtures("handed_over")


def test_checksum_is_the_xor_of_all_before_the_star():
    assert checked_line("u 0") == b"u 0 *69\n"  # 0x75 ^ 0x20 ^ 0x30 ^ 0x20
    assert line_text(b"u 0 *69") == "u 0"
    assert line_text(b"u 0 *70") is None
    assert line_text(b"u 0") is None


@given(st.lists(st.binary(max_size=300), max_size=20))
def test_no_bytes_make_the_reader_raise_or_keep_more_than_a_line(chunks):
    reader = LineReader()
    for chunk in chunks:
        for text in reader.feed(chunk):
            assert isinstance(text, str)
    assert len(reader._rest) <= 256


@given(st.binary(max_size=50).filter(lambda b: b"\n" not in b and b"\r" not in b), st.integers(1, 7))
def test_a_line_is_found_whatever_came_before_and_however_it_is_cut(garbage, cut):
    reader = LineReader()
    data = garbage + b"\n" + checked_line("0.5 1.25")
    texts = [t for i in range(0, len(data), cut) for t in reader.feed(data[i : i + cut])]
    assert texts[-1] == "0.5 1.25"
