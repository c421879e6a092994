"""A visual sample and its message."""

from stillarm.common.datagrams.fields import plain_types
from stillarm.common.datagrams.messages import Visual
from stillarm.common.datagrams.visual_sample import LinkTimes, VisualSample, visual_message


def test_the_visual_message_holds_the_sample_s_fields() -> None:
    """By name, type and order; all but `restarted`, which the receiver sets."""
    sample, message = list(plain_types(VisualSample).items()), list(plain_types(Visual).items())
    assert sample[:-1] == message[1:-3] and sample[-1][0] == "restarted"


def test_the_message_has_the_session_first_and_the_times_last() -> None:
    message = visual_message(7, VisualSample(4, 31, 0, 1.5), LinkTimes(1.0, 2.0, 3.0))
    assert (message.timestamp_session, message.frame, message.started_cycle) == (7, 4, 31)
    assert (message.sent_s, message.received_s, message.answered_s) == (1.0, 2.0, 3.0)
