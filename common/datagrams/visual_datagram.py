"""A visual sample as the message Visual, and back; with the times from which the two clocks are compared."""

from math import nan
from typing import Any, NamedTuple

import msgspec

from stillarm.common.datagrams.messages import Visual
from stillarm.common.datagrams.visual_sample import VisualSample


class LinkTimes(NamedTuple):
    """When the latest timestamp left the controller (on its clock), when it was read and when these data left
    (on the supervisor's), s; NaN where unknown.
    """

    sent_s: float = nan
    received_s: float = nan
    answered_s: float = nan


NO_TIMES = LinkTimes()


def visual_message(controller_session: int, sample: VisualSample, times: LinkTimes = NO_TIMES) -> Visual:
    """The message that answers the timestamps of a session; `restarted` stays behind: the receiver knows it."""
    fields: tuple[Any, ...] = (controller_session, *msgspec.structs.astuple(sample)[:-1], *times)
    return Visual(*fields)


def visual_sample(message: Visual) -> VisualSample:
    """The sample in a message."""
    return msgspec.convert(message, VisualSample, from_attributes=True)


def link_times(message: Visual) -> LinkTimes:
    """The times in a message."""
    return LinkTimes(message.sent_s, message.received_s, message.answered_s)
