"""A visual sample and its message."""

from hypothesis import given
from hypothesis import strategies as st

from stillarm.common.datagrams.fields import plain_types
from stillarm.common.datagrams.messages import (
    Visual,
)
from stillarm.common.datagrams.visual_datagram import LinkTimes, link_times, visual_message, visual_sample
from stillarm.common.datagrams.visual_sample import VisualSample


@given(
    st.builds(
        VisualSample,
        st.integers(-1, 2**63),
        st.integers(-1, 2**63),
        st.integers(0, 9),
        *[st.floats(allow_nan=False)] * 9,
        *[st.integers(0, 1000)] * 2,
    )
)
def test_a_visual_sample_comes_back(sample: VisualSample) -> None:
    message = visual_message(7, sample, LinkTimes(1.0, 2.0, 3.0))
    assert (message.timestamp_session, message.started_cycle) == (7, sample.started_cycle)
    assert visual_sample(message) == sample
    assert link_times(message) == (1.0, 2.0, 3.0)


def test_the_visual_message_holds_the_sample_s_fields() -> None:
    """By name, type and order; all but `restarted`, which the receiver sets."""
    sample, message = list(plain_types(VisualSample).items()), list(plain_types(Visual).items())
    assert sample[:-1] == message[1:-3] and sample[-1][0] == "restarted"
