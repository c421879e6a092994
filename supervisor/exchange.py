"""The supervisor's side of the exchange with the controller (the paper's Fig. 2). Pure: bytes in, bytes out."""

from collections import deque
from math import nan
from typing import NamedTuple

from stillarm.common.datagrams.datagram import LinkCounts, Peer
from stillarm.common.datagrams.messages import Timestamp
from stillarm.common.datagrams.visual_sample import LinkTimes, VisualSample, visual_message


class Started(NamedTuple):
    """What a cycle began with: the controller's session and its cycle n_i; session 0 before the first timestamp."""

    session: int
    cycle: int


class SupervisorExchange:
    """Keeps only the latest timestamp, and answers with visual data that carry the timestamp at the cycle's start.

    A cycle begins when an image is requested and ends when its data are sent. With several buffers queued at the
    camera, `cycles_in_flight` cycles overlap. Images arrive in the order of their requests.
    """

    def __init__(self, key: bytes, session: int, cycles_in_flight: int) -> None:
        """key: signs all datagrams. session: a number of this process that was never used before."""
        self._in_flight = cycles_in_flight
        self._begun: deque[Started] = deque()
        self._peer = Peer(key, (Timestamp,), session)
        self._sent_s = self._received_s = nan  # of the latest timestamp
        self.latest = Started(0, -1)

    @property
    def counts(self) -> LinkCounts:
        """Counts of the timestamps since the start."""
        return self._peer.counts

    def take(self, datagrams: list[bytes], received_s: float = nan) -> None:
        """Read the datagrams that have arrived and keep the latest timestamp. received_s: this clock's time."""
        for data in datagrams:
            datagram = self._peer.receive(data)
            if datagram is not None:
                self.latest = Started(datagram.session, datagram.body.cycle)
                self._sent_s, self._received_s = datagram.body.sent_s, received_s

    def begin_cycles(self) -> int:
        """Begin as many cycles as may be in flight, with the latest timestamp as n_i. Returns their number."""
        new = self._in_flight - len(self._begun)
        self._begun.extend([self.latest] * new)
        return new

    def oldest(self) -> Started:
        """The timestamp with which the oldest cycle in flight began: its image comes next."""
        return self._begun[0]

    def end_cycle(self, sample: VisualSample, answered_s: float = nan) -> bytes:
        """End the oldest cycle. Returns the datagram with its visual data and n_i. answered_s: this clock's time."""
        started = self._begun.popleft()
        times = LinkTimes(self._sent_s, self._received_s, answered_s)
        return self._peer.encode(visual_message(started.session, sample, times))
