"""Counters that only grow, whatever the camera counts."""

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from stillarm.drivers.cameras.vendors.frame_counter import FrameCounter


def test_a_gige_block_number_wraps_over_zero():
    counter = FrameCounter(65535)
    assert [counter.accept(raw) for raw in (65534, 65535, 1, 3)] == [65534, 65535, 65536, 65538]
    assert counter.wrong == 0


@given(st.lists(st.integers(0, 2**64), min_size=1, max_size=50), st.sampled_from([0, 65535]))
def test_counts_only_grow(raw, modulus):
    counter = FrameCounter(modulus)
    counts = [counter.accept(value) for value in raw]
    assert all(after > before for before, after in pairwise(counts))
