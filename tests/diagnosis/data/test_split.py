"""What is held out lies interleaved in time; what a user states is held out exactly."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.user_error import UserError
from stillarm.diagnosis.data.split import interleaved, stated


@settings(max_examples=50, deadline=None)
@given(st.floats(3.0, 600.0))
def test_a_third_is_held_out_in_blocks_over_the_whole_time(duration_s: float) -> None:
    split = interleaved(duration_s)
    lengths = np.diff(split.edges_s)
    assert split.edges_s[0] == 0.0
    assert split.edges_s[-1] == pytest.approx(duration_s)
    assert lengths[split.held].sum() == pytest.approx(duration_s / 3.0)
    middles = 0.5 * (split.edges_s[1:] + split.edges_s[:-1])[split.held]
    assert middles[0] < 0.25 * duration_s
    assert middles[-1] > 0.75 * duration_s
    assert np.max(np.diff(middles)) < 0.35 * duration_s


@settings(max_examples=50, deadline=None)
@given(st.floats(0.0, 10.0), st.floats(0.5, 5.0), st.floats(-100.0, 1000.0))
def test_stated_spans_are_held_out_in_the_recordings_own_time(
    start: float, length: float, origin: float
) -> None:
    split = stated([(origin + start, origin + start + length)], origin, 20.0)
    time = np.linspace(0.0, 19.999, 4001)
    inside = (time > start + 1e-6) & (time < start + length - 1e-6)
    outside = (time < start - 1e-6) | (time > start + length + 1e-6)
    held = split.held[split.blocks_of(time)]
    assert held[inside].all()
    assert not held[outside].any()


@pytest.mark.parametrize(
    ("spans", "words"),
    [
        ([(5.0, 25.0)], "within the recording"),
        ([(-1.0, 5.0)], "within the recording"),
        ([(1.0, 5.0), (4.0, 6.0)], "overlaps"),
        ([(0.0, 20.0)], "leaves nothing to fit"),
    ],
)
def test_spans_that_cannot_be_held_out_are_refused(spans: list[tuple[float, float]], words: str) -> None:
    with pytest.raises(UserError, match=words):
        stated(spans, 0.0, 20.0)
